#include "calibrate/witnesses.hpp"

#include <gtest/gtest.h>

namespace gripline::calibrate {
namespace {

/// Errors of four starts in each of so many stretches; every other stretch differs by `odd`.
ForecastErrors errors_of(double size, std::size_t stretches, double odd = 1.0) {
  ForecastErrors out;
  for (std::size_t i = 0; i < 4 * stretches; ++i) {
    out.square.push_back(i / 4 % 2 == 0 ? size : size * odd);
    out.stretch.push_back(i / 4);
    out.log.push_back(0);
  }
  return out;
}

/// Two stretches have no interval: they neither speak for an effect nor against it.
TEST(Witnesses, LogsHeldOutThatAreTooShortHaveNoSay) {
  const ForecastErrors with = errors_of(0.64, 12, 1.1), without = errors_of(1.0, 12);
  const WitnessChange alone = compare({with, {}}, {without, {}});
  EXPECT_GT(alone.sure, sure_enough);
  EXPECT_TRUE(alone.smaller);
  for (const double held_out : {0.5, 2.0}) {
    const WitnessErrors both{with, errors_of(held_out, 2)};
    EXPECT_FALSE(both.held_out_says());
    EXPECT_EQ(both.rms(), with.rms());
    const WitnessChange beside = compare(both, {without, errors_of(1.0, 2)});
    EXPECT_EQ(beside.sure, alone.sure);
    EXPECT_TRUE(beside.smaller);
  }
}

TEST(Witnesses, TwoThatAgreeAreSurerThanOneAndEachMaySpeakAgainst) {
  const ForecastErrors better = errors_of(0.8, 6, 1.3), worse = errors_of(1.25, 6, 0.8), same = errors_of(1.0, 6);
  const WitnessErrors without{same, same};
  EXPECT_TRUE(without.held_out_says());
  const WitnessChange one = compare({better, {}}, {same, {}}), agreed = compare({better, better}, without);
  EXPECT_TRUE(agreed.smaller);
  EXPECT_NEAR(agreed.sure, std::sqrt(2.0) * one.sure, 1e-9);
  EXPECT_FALSE(compare({better, worse}, without).smaller);
  EXPECT_FALSE(compare({worse, better}, without).smaller);
  EXPECT_LT(compare({better, worse}, without).sure, one.sure);
}

/// What is smaller by all witnesses is more likely than not by each: no effect stays on the credit of others alone.
TEST(Witnesses, SmallerIsACertaintyAboveOneHalf) {
  for (const double size : {0.9, 0.999, 1.0, 1.001, 1.1}) {
    const WitnessChange by_it = compare({errors_of(size, 6, 1.01), {}}, {errors_of(1.0, 6), {}});
    EXPECT_EQ(by_it.smaller, by_it.sure > 0.0) << size;
  }
}

}  // namespace
}  // namespace gripline::calibrate
