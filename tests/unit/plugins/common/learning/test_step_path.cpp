#include "common/learning/step_path.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gripline::learning {
namespace {

/// A step of 20 ms at `v` along a road whose grade goes from `grade` by `curve` per metre.
Sample step_on(double v, double grade, double curve) {
  Sample k;
  k.dt = 0.02;
  k.x.vx = v;
  k.at.grade = grade;
  k.at_next.grade = grade + curve * v * k.dt;
  return k;
}

TEST(StepPath, AFlatRoadPressesByTheWeight) { EXPECT_EQ(road_load(step_on(28.0, 0.0, 0.0)), 1.0); }

TEST(StepPath, CrestsAndDipsPressByTheirRadius) {
  for (const double radius : {2500.0, 400.0, -300.0}) {
    const double expected = 1.0 - 28.0 * 28.0 / radius / gravity;
    EXPECT_NEAR(road_load(step_on(28.0, 0.0, -1.0 / radius)), expected, 1e-9) << radius;
    EXPECT_NEAR(road_load(step_on(28.0, 0.1, -1.0 / radius)), expected + std::cos(0.1) - 1.0, 1e-9) << radius;
  }
  EXPECT_EQ(road_load(step_on(28.0, 0.0, -1.0)), 0.5);    // no road: the place jumped
  EXPECT_EQ(road_load(step_on(0.001, 0.0, 100.0)), 1.0);  // a car that stands
}

// A bank that turns with the road is a curved surface, whichever way the car drives round it.
TEST(StepPath, BankedTurnsPressTheCarDown) {
  for (const double direction : {1.0, -1.0}) {
    Sample k = step_on(20.0, 0.0, 0.0);
    k.at.direction = direction;
    k.at.kappa = 0.02;
    k.at.bank = k.at_next.bank = direction * 0.08;
    EXPECT_NEAR(road_load(k), std::cos(0.08) + 20.0 * 20.0 * 0.02 * std::sin(0.08) / gravity, 1e-12);
  }
}

}  // namespace
}  // namespace gripline::learning
