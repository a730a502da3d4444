#include "common/learning/step_path.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/learning_rig.hpp"

namespace gripline::learning {
namespace test_step_path {

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

// A crest takes load off both axles, and brakes then use more of what friction is left.
TEST(StepPath, BrakesShareTheFrictionOfALightenedCar) {
  rig::Nominal nominal("ekinematic");
  PluginContext context;
  context.car = rig::small_car();
  context.nominal = &nominal.prediction();
  context.hold = Hold::zoh;
  const StraightDrive drive(context);
  const FrictionEllipse ellipse{0.5, 0.5, 0.6};
  const PeakForces peaks{0.2, 0.2};
  const CorrectionTerms terms{.ellipse = ellipse, .peaks = peaks};
  const auto force = [](Axle, double) { return 0.0; };
  const LearnedCar car{context.car, drive, terms, force};
  Sample k = step_on(2.0, 0.0, -0.5);
  k.x_next = k.x;
  k.u.d = -0.1;
  const double load = road_load(k), braking = drive.at(2.0, -0.1, {}).drive_force;
  ASSERT_LT(load, 0.85);
  ASSERT_LT(braking, 0.0);
  const StepPath path = predicted_path({k.x.vx, 0.0, 0.0}, k, car);
  EXPECT_NEAR(path.load_front, load * ellipse.side_share(Axle::front, braking, load, peaks.front), 1e-12);
  EXPECT_NEAR(path.load_rear, load * ellipse.side_share(Axle::rear, braking, load, peaks.rear), 1e-12);
  EXPECT_LT(path.load_front, load * ellipse.side_share(Axle::front, braking, 1.0, peaks.front) - 1e-3);
}

}  // namespace test_step_path
}  // namespace gripline::learning
