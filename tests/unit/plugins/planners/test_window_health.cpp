#include "planners/time_optimal/window_health.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gripline {
namespace test_window_health {

using time_optimal::WindowHealth;

/// Control steps without a plan until the window is given up, where the belief has moved by so much.
int steps_until_given_up(WindowHealth& health, double moved) {
  int steps = 0;
  for (; steps < 1000 && !health.is_given_up(moved); ++steps) static_cast<void>(health.control_step(false));
  return steps;
}

TEST(WindowHealth, IsStuckAfterNineNewtonStepsForNothing) {
  WindowHealth health(0.02);
  for (int i = 0; i < 8; ++i) health.newton_step(false);
  EXPECT_FALSE(health.is_stuck());
  health.newton_step(true);
  for (int i = 0; i < 9; ++i) health.newton_step(false);
  EXPECT_TRUE(health.is_stuck());
  health.restart();
  EXPECT_FALSE(health.is_stuck());
}

TEST(WindowHealth, StallsEverySixteenControlStepsWithoutAPlan) {
  WindowHealth health(0.02);
  for (int i = 1; i <= 48; ++i) EXPECT_EQ(health.control_step(false), i % 16 == 0) << i;
  for (int i = 1; i <= 15; ++i) EXPECT_FALSE(health.control_step(false));
  EXPECT_FALSE(health.control_step(true));
  EXPECT_FALSE(health.control_step(false));
}

TEST(WindowHealth, IsLostAfterTwentySixControlStepsWithoutAPlan) {
  WindowHealth health(0.02);
  for (int i = 1; i <= 30; ++i) {
    static_cast<void>(health.control_step(false));
    EXPECT_EQ(health.is_lost(), i > 25) << i;
  }
  static_cast<void>(health.control_step(true));
  EXPECT_FALSE(health.is_lost());
}

TEST(WindowHealth, IsGivenUpLaterEachTimeUntilThereIsAPlan) {
  WindowHealth health(0.02);
  for (const int expected : {51, 101, 151, 151}) {
    EXPECT_EQ(steps_until_given_up(health, 0.01), expected);
    health.begin_for(0.01);
  }
  static_cast<void>(health.control_step(true));
  EXPECT_EQ(steps_until_given_up(health, 0.01), 51);
}

TEST(WindowHealth, IsGivenUpSoonerForAnotherCar) {
  WindowHealth health(0.02);
  EXPECT_EQ(steps_until_given_up(health, 0.01), 51);
  health.begin_for(0.01);
  EXPECT_EQ(steps_until_given_up(health, 0.06), 26);
  health.begin_for(0.06);
  EXPECT_EQ(steps_until_given_up(health, 0.01), 51);  // patience begins anew
}

TEST(WindowHealth, CountsSecondsAtAnyControlStep) {
  for (const double dt : {0.005, 0.01, 0.02, 0.04}) {
    const auto in_time = [dt](int steps, double seconds) { return std::abs(steps * dt - seconds) < 1.6 * dt; };
    WindowHealth stalls(dt), is_lost(dt), is_given_up(dt);
    int stalled = 1, lost = 0;
    while (stalled < 1000 && !stalls.control_step(false)) ++stalled;
    EXPECT_TRUE(in_time(stalled, 0.3)) << dt << ": " << stalled;
    for (; lost < 1000 && !is_lost.is_lost(); ++lost) static_cast<void>(is_lost.control_step(false));
    EXPECT_TRUE(in_time(lost, 0.5)) << dt << ": " << lost;
    for (const double expected : {1.0, 2.0, 3.0, 3.0}) {
      const int steps = steps_until_given_up(is_given_up, 0.01);
      EXPECT_TRUE(in_time(steps, expected)) << dt << ": " << steps;
      is_given_up.begin_for(0.01);
    }
  }
}

}  // namespace test_window_health
}  // namespace gripline
