#include "planners/time_optimal/window_health.hpp"

#include <gtest/gtest.h>

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
  WindowHealth health;
  for (int i = 0; i < 8; ++i) health.newton_step(false);
  EXPECT_FALSE(health.is_stuck());
  health.newton_step(true);
  for (int i = 0; i < 9; ++i) health.newton_step(false);
  EXPECT_TRUE(health.is_stuck());
  health.restart();
  EXPECT_FALSE(health.is_stuck());
}

TEST(WindowHealth, StallsEverySixteenControlStepsWithoutAPlan) {
  WindowHealth health;
  for (int i = 1; i <= 48; ++i) EXPECT_EQ(health.control_step(false), i % 16 == 0) << i;
  for (int i = 1; i <= 15; ++i) EXPECT_FALSE(health.control_step(false));
  EXPECT_FALSE(health.control_step(true));
  EXPECT_FALSE(health.control_step(false));
}

TEST(WindowHealth, IsLostAfterTwentySixControlStepsWithoutAPlan) {
  WindowHealth health;
  for (int i = 1; i <= 30; ++i) {
    static_cast<void>(health.control_step(false));
    EXPECT_EQ(health.is_lost(), i > 25) << i;
  }
  static_cast<void>(health.control_step(true));
  EXPECT_FALSE(health.is_lost());
}

TEST(WindowHealth, IsGivenUpLaterEachTimeUntilThereIsAPlan) {
  WindowHealth health;
  for (const int expected : {51, 101, 151, 151}) {
    EXPECT_EQ(steps_until_given_up(health, 0.01), expected);
    health.begin_for(0.01);
  }
  static_cast<void>(health.control_step(true));
  EXPECT_EQ(steps_until_given_up(health, 0.01), 51);
}

TEST(WindowHealth, IsGivenUpSoonerForAnotherCar) {
  WindowHealth health;
  EXPECT_EQ(steps_until_given_up(health, 0.01), 51);
  health.begin_for(0.01);
  EXPECT_EQ(steps_until_given_up(health, 0.06), 26);
  health.begin_for(0.06);
  EXPECT_EQ(steps_until_given_up(health, 0.01), 51);  // patience begins anew
}

}  // namespace test_window_health
}  // namespace gripline
