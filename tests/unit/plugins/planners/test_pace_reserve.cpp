#include "planners/time_optimal/pace_reserve.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace gripline {
namespace test_pace_reserve {

using time_optimal::LapParams;
using time_optimal::PaceReserve;

constexpr double top = 60;  // [m/s]

LapParams params() {
  LapParams p;
  p.mu_lo = 0.2;
  p.mu_hi = 1.3;
  p.pace = 0.975;
  p.pace_fall = 0.0011;
  p.pace_kept = 0.7;
  return p;
}

TEST(PaceReserve, IsWholeUntilTheBeliefIsTrustedAndAtTheFrictionThatIsExpected) {
  PaceReserve reserve(params(), top);
  EXPECT_NEAR(reserve.pace(40), 0.975 - 40 * 0.0011, 1e-12);
  reserve.set(0.5, {0.5, 0.5}, false);
  EXPECT_NEAR(reserve.pace(40), 0.975 - 40 * 0.0011, 1e-12);
  for (const double mu : {1.0, 1.2}) {
    reserve.set(mu, {mu, mu}, true);
    EXPECT_NEAR(reserve.pace(40), 0.975 - 40 * 0.0011, 1e-12) << mu;
  }
}

// Laps are solved for the least friction that is expected. That no more is planned for, to be sure of what is believed,
// slows down no more.
TEST(PaceReserve, LessFrictionThanIsPlannedForIsDrivenMoreSlowly) {
  PaceReserve reserve(params(), top);
  for (const bool trusted : {false, true}) {
    reserve.set(0.2, {0.2, 0.2}, trusted);
    const double at_least = reserve.pace(40);
    reserve.set(0.05, {0.05, 0.05}, trusted);
    EXPECT_NEAR(reserve.pace(40), 0.5 * at_least, 1e-12);
    reserve.set(0.05, {0.8, 0.8}, trusted);
    EXPECT_EQ(reserve.pace(40), at_least);
    reserve.set(-0.3, {-0.3, -0.3}, trusted);
    EXPECT_NEAR(reserve.pace(40), std::sqrt(0.01 / 0.2) * at_least, 1e-12);
  }
}

// Of friction that has risen at once no more is used than is driven.
TEST(PaceReserve, UsesNoMoreOfTheFrictionThanIsDriven) {
  PaceReserve reserve(params(), top);
  reserve.set(0.2, {0.05, 0.05}, true);
  const double all = reserve.use_of_friction(40);
  reserve.set(0.2, {0.05, 0.2}, true);
  EXPECT_NEAR(reserve.use_of_friction(40), 0.5 * all, 1e-12);
  reserve.set(0.2, {0.05, 1.0}, true);  // a plan for 0.2 does not use more of it
  EXPECT_NEAR(reserve.use_of_friction(40), 0.5 * all, 1e-12);
}

// Friction falls from mu to a normally distributed one; its mean fall by a sum over that distribution.
TEST(PaceReserve, ShrinksWithTheMeanFallThatFrictionCanTake) {
  const LapParams p = params();
  const auto mean_fall = [&](double mu) {
    double sum = 0, weight = 0;
    for (int i = -6000; i < 6000; ++i) {
      const double z = 1e-3 * i;
      const double density = std::exp(-0.5 * z * z);
      sum += density * std::max(0.0, mu - (p.pace_friction + z * p.pace_spread));
      weight += density;
    }
    return sum / weight / mu;
  };
  PaceReserve reserve(p, top);
  reserve.set(0.7, {0.7, 0.7}, true);
  const double share = mean_fall(0.7) / mean_fall(1.0), kept = 0.7 + 0.3 * share;
  ASSERT_LT(share, 0.5);
  EXPECT_NEAR(1 - reserve.pace(20), kept * (0.025 + 0.0011 * 20), 1e-6);
}

TEST(PaceReserve, RefusesToDriveFasterPlansOrMoreFrictionMoreSlowly) {
  const auto refusal = [](const LapParams& p) -> std::string {
    try {
      PaceReserve reserve(p, top);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(params()), "");
  LapParams steep = params();
  steep.pace_fall = 0.02;
  EXPECT_THAT(refusal(steep), testing::HasSubstr("pace_fall"));
  LapParams little = params();
  little.pace = 0.5;
  little.pace_fall = 0;
  little.pace_kept = 0;
  little.pace_spread = 0.05;
  EXPECT_THAT(refusal(little), testing::HasSubstr("pace_kept"));
}

}  // namespace test_pace_reserve
}  // namespace gripline
