#include "diagnose/real_logs/held_out_comparison.hpp"

#include <gtest/gtest.h>

namespace gripline::diagnose {
namespace test_diagnose_held_out_comparison {

using calibrate::ForecastErrors;

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
TEST(HeldOutComparison, LogsHeldOutThatAreTooShortHaveNoSay) {
  const ForecastErrors with = errors_of(0.64, 12, 1.1), without = errors_of(1.0, 12);
  const UnfittedChange alone = compare_unfitted({with, {}}, {without, {}});
  EXPECT_GT(alone.significance, least_significance);
  EXPECT_TRUE(alone.smaller);
  for (const double held_out : {0.5, 2.0}) {
    const UnfittedErrors both{with, errors_of(held_out, 2)};
    EXPECT_FALSE(both.held_out_counts());
    EXPECT_EQ(both.rms(), with.rms());
    const UnfittedChange beside = compare_unfitted(both, {without, errors_of(1.0, 2)});
    EXPECT_EQ(beside.significance, alone.significance);
    EXPECT_TRUE(beside.smaller);
  }
}

TEST(HeldOutComparison, TwoThatAgreeAreSurerThanOneAndEachMaySpeakAgainst) {
  const ForecastErrors better = errors_of(0.8, 6, 1.3), worse = errors_of(1.25, 6, 0.8), same = errors_of(1.0, 6);
  const UnfittedErrors without{same, same};
  EXPECT_TRUE(without.held_out_counts());
  const UnfittedChange one = compare_unfitted({better, {}}, {same, {}}),
                       agreed = compare_unfitted({better, better}, without);
  EXPECT_TRUE(agreed.smaller);
  EXPECT_NEAR(agreed.significance, std::sqrt(2.0) * one.significance, 1e-9);
  EXPECT_FALSE(compare_unfitted({better, worse}, without).smaller);
  EXPECT_FALSE(compare_unfitted({worse, better}, without).smaller);
  EXPECT_LT(compare_unfitted({better, worse}, without).significance, one.significance);
}

/// What is smaller by both kinds of time is more likely than not by each: no effect stays on the credit of others
/// alone.
TEST(HeldOutComparison, SmallerIsACertaintyAboveOneHalf) {
  for (const double size : {0.9, 0.999, 1.0, 1.001, 1.1}) {
    const UnfittedChange by_it = compare_unfitted({errors_of(size, 6, 1.01), {}}, {errors_of(1.0, 6), {}});
    EXPECT_EQ(by_it.smaller, by_it.significance > 0.0) << size;
  }
}

}  // namespace test_diagnose_held_out_comparison
}  // namespace gripline::diagnose
