#include "common/learning/step_path.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "support/learning_rig.hpp"

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

/// Of linear tyres at a constant speed, the car's lateral motion is x' = A x with x = (vy, omega): x(dt) = exp(A dt) x(0).
TEST(StepPath, TyresBringBackALateralSpeedWithinAStep) {
  rig::Nominal nominal("ekinematic");
  const Car car = rig::small_car();
  PluginContext context;
  context.car = car;
  context.dt = rig::dt;
  context.hold = Hold::zoh;
  context.nominal = &nominal.prediction();
  const StraightDrive drive(context);
  const double front = 0.3, rear = 0.4;  // [N/rad]
  const auto force = [&](Axle axle, double slip) { return (axle == Axle::front ? front : rear) * slip; };
  const ResistanceForce resistance;
  const FrictionEllipse ellipse;
  const PeakForces peaks;
  const LearnedCar learned{car, drive, resistance, ellipse, peaks, force};
  for (const double v : {0.5, 2.0}) {
    Sample k = step_on(v, 0.0, 0.0);
    k.x_next = k.x;
    // The input at which this speed is kept.
    double lo = 0.0, hi = 1.0;
    for (int i = 0; i < 50; ++i) (drive.at(v, 0.5 * (lo + hi), k.at).forward < 0.0 ? lo : hi) = 0.5 * (lo + hi);
    k.u.d = lo;
    Eigen::Matrix2d A;
    const double turn = (front * car.lf - rear * car.lr) / v;
    A << -(front + rear) / (car.m * v), -v - turn / car.m, -turn / car.Iz,
        -(front * car.lf * car.lf + rear * car.lr * car.lr) / (car.Iz * v);
    Eigen::Matrix2d expected = Eigen::Matrix2d::Identity(), term = expected;
    for (int i = 1; i < 60; ++i) {
      term *= A * (k.dt / i);
      expected += term;
    }
    const StepJacobian by = end_by_begin({v, 0.0, 0.0}, k, learned);
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j) {
        const double unit = (i == 0 ? v : v / car.lf) / (j == 0 ? v : v / car.lf);
        EXPECT_NEAR(by[i + 1][j + 1] / unit, expected(i, j) / unit, 0.02) << v << ", " << i << ", " << j;
      }
    EXPECT_NEAR(by[1][0], 0.0, 1e-9);
    EXPECT_NEAR(by[0][1], 0.0, 1e-6);
  }
}

}  // namespace
}  // namespace gripline::learning
