#include "measured/table/formula.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "config/errors.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {
namespace test_formula {

using testing::HasSubstr;

DelimitedTable table() {
  DelimitedTable t;
  t.name = {"throttle", "brake", "Steering Angle", "hole"};
  t.unit.resize(4);
  t.column = {{0, 50, 100}, {2000, 0, 0}, {-15, 0, 30}, {1, not_a_number, 3}};
  t.line = {2, 3, 4};
  return t;
}

std::vector<double> values(const std::string& text) {
  const auto t = table();
  return Formula(text, t, "d").evaluate(t, {0.0, 0.5, 1.0});
}

std::string why(const std::string& text) {
  try {
    values(text);
  } catch (const InputError& e) {
    return e.what();
  }
  return "read";
}

TEST(Formula, MakesOneCommandOfTwoPedals) {
  EXPECT_THAT(values("throttle/100 - brake/4000"), testing::ElementsAre(-0.5, 0.5, 1.0));
}

TEST(Formula, BindsAsPeopleExpect) {
  EXPECT_EQ(values("2 + 3 * 4 ^ 2 / 8 - 1")[0], 7.0);
  EXPECT_EQ(values("-2 ^ 2")[0], -4.0);
  EXPECT_EQ(values("2 ^ -1")[0], 0.5);
  EXPECT_EQ(values("(1 + 2) * -3")[0], -9.0);
  EXPECT_EQ(values("10 - 3 - 2")[0], 5.0);
  EXPECT_EQ(values("1 + 1 == 2 && !(3 < 2) || 0")[0], 1.0);
}

TEST(Formula, NamesWithBlanksStandInBackquotes) {
  EXPECT_EQ(values("`Steering Angle` / 15")[2], 2.0);
  EXPECT_NEAR(values("rad(`Steering Angle`)")[2], std::numbers::pi / 6, 1e-15);
}

TEST(Formula, ChoosesClampsHoldsAndTakesRates) {
  EXPECT_THAT(values("if(brake > 0, 0, throttle)"), testing::ElementsAre(0, 50, 100));
  EXPECT_THAT(values("clamp(throttle, 10, 60)"), testing::ElementsAre(10, 50, 60));
  EXPECT_THAT(values("hold(hole)"), testing::ElementsAre(1, 1, 3));
  const auto rate = values("rate(throttle)");
  EXPECT_TRUE(std::isnan(rate[0]));
  EXPECT_EQ(rate[1], 100.0);
  EXPECT_EQ(values("rate(hole)")[2], 2.0);  // over the rows that have it
  EXPECT_EQ(values("min(1, 2) + max(3, 4) + mod(-1, 3) + atan2(0, 1)")[0], 7.0);
}

TEST(Formula, AMissingCellMakesAMissingValueWhereItIsUsed) {
  EXPECT_TRUE(std::isnan(values("hole + 1")[1]));
  EXPECT_TRUE(std::isnan(values("max(hole, 0)")[1]));
  EXPECT_EQ(values("if(throttle > 10, 7, hole)")[1], 7.0);
}

TEST(Formula, AMissingCellIsNeitherTrueNorFalse) {
  for (const char* unknown : {"hole > 0.5", "hole < 0.5", "hole >= 1", "hole <= 1", "hole == 1", "hole != 0",
                              "2 < hole", "!hole", "!(hole < 0.5)", "hole && 1", "1 && hole", "hole || 0", "0 || hole",
                              "hole ^ 0", "1 ^ hole", "if(hole > 0.5, throttle, 0)"})
    EXPECT_TRUE(std::isnan(values(unknown)[1])) << unknown;
  for (const char* known : {"hole && 0", "0 && hole", "!(hole || 1)", "!(1 || hole)"})
    EXPECT_EQ(values(known)[1], 0.0) << known;
  EXPECT_THAT(values("2 && 3"), testing::Each(1.0));
  EXPECT_THAT(values("0 || 0"), testing::Each(0.0));
}

TEST(Formula, MistakesAreToldWithTheirPlaceAndTheNearestName) {
  EXPECT_THAT(why("throtle / 100"), AllOf(HasSubstr("d \"throtle / 100\""), HasSubstr("did you mean \"throttle\"?")));
  EXPECT_THAT(why("sqr(throttle)"), HasSubstr("did you mean \"sqrt\"?"));
  EXPECT_THAT(why("min(throttle)"), HasSubstr("min() takes 2 values, found 1"));
  EXPECT_THAT(why("(throttle"), HasSubstr("expected \")\""));
  EXPECT_THAT(why("throttle 2"), HasSubstr("unexpected \"2\""));
  EXPECT_THAT(why("throttle +"), HasSubstr("ends where a value was expected"));
  EXPECT_THAT(why("`throttle"), HasSubstr("not closed"));
  EXPECT_THAT(why(std::string(300, '-').append("1")), HasSubstr("nested too deeply"));
}

TEST(Formula, NamesInBackquotesAreListed) {
  EXPECT_EQ(quoted_names("`/a.x` + 2 * max(b, `c d`) - `/a.x`"), (std::vector<std::string>{"/a.x", "c d", "/a.x"}));
  EXPECT_TRUE(quoted_names("a + `open").empty());
}

}  // namespace test_formula
}  // namespace gripline::measured
