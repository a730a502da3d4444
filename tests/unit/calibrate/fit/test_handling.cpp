#include "calibrate/fit/handling.hpp"

#include <gtest/gtest.h>

#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace test_handling {

using test::CalibrateRig;
using test::small_car_world;

std::optional<double> gradient_of(const char* patch) {
  const CalibrateRig rig(small_car_world(patch));
  constexpr double speed = 2.0, turn = 0.1;  // gently, where tyres are nearly linear
  const auto angle = understeer_angle(rig.vehicle.car(), rig.vehicle.car().params(), speed, turn);
  if (!angle) return std::nullopt;
  return *angle / (speed * turn);
}

TEST(Handling, FrictionIsReadFromTheTyres) {
  const CalibrateRig rig;
  const Friction friction = friction_of(rig.vehicle.car(), rig.spec.car.car, rig.vehicle.car().params(), {});
  ASSERT_TRUE(friction.known);
  EXPECT_NEAR(friction.total, 12.0 / (1.6 * gravity), 1e-12);
  EXPECT_NEAR(friction.front, 6.0 / (1.6 * gravity * 0.09 / 0.17), 1e-12);
}

/// m / L (lr / front stiffness - lf / rear stiffness), of linear tyres.
double closed_form(double front, double rear) { return 1.6 / 0.17 * (0.09 / front - 0.08 / rear); }

TEST(Handling, TheUndersteerGradientIsThatOfLinearTyres) {
  constexpr double nearly = 2e-5;  // a thousandth: tyres are not quite linear
  EXPECT_NEAR(*gradient_of("{}"), closed_form(5 * 1.4 * 6, 7 * 1.4 * 6), nearly);
  const auto over = gradient_of(R"({"plant": {"params": {"Bf": 9, "Br": 4}}})");
  EXPECT_NEAR(*over, closed_form(9 * 1.4 * 6, 4 * 1.4 * 6), nearly);
  EXPECT_LT(*over, 0.0);
}

TEST(Handling, WhatActsOnTheSteeringIsNoUndersteer) {
  const double plain = *gradient_of("{}");
  const auto with = gradient_of(R"({"plant": {"effects": [
      {"plugin": "steer_offset", "params": {"d0": 0.05}}, {"plugin": "steer_map", "params": {"g": 0.8, "a": 0.2}},
      {"plugin": "steer_lag", "params": {"tau": 0.1}}, {"plugin": "input_delay", "params": {"T": 0.04}}]}})");
  ASSERT_TRUE(with);
  EXPECT_NEAR(*with, plain, 1e-6);
}

TEST(Handling, ASofterFrontAxleMakesTheCarUndersteer) {
  const auto soft = gradient_of(R"({"plant": {"effects": [{"plugin": "front_stiff", "params": {"k": -0.3}}]}})");
  ASSERT_TRUE(soft);
  EXPECT_NEAR(*soft, closed_form(0.7 * 5 * 1.4 * 6, 7 * 1.4 * 6), 2e-5);
}

/// In corners in which tyres are not linear any more, a car's model says of them what its log does.
TEST(Handling, AModelIsAskedInTheCornersOfTheLog) {
  const CalibrateRig rig;
  const measured::Session log = test::drive(rig.vehicle.car(), {.seconds = 90, .noise = 1});
  const measured::Session* const one = &log;
  const auto by_log = measured::steady_turning({&one, 1}, 0.17, 2.0).turning;
  ASSERT_TRUE(by_log);
  const auto by_model = gradient_in(*by_log, rig.vehicle.car(), rig.vehicle.car().params());
  ASSERT_TRUE(by_model);
  EXPECT_NEAR(*by_model, by_log->gradient, 0.07 * by_log->gradient);
  EXPECT_GT(*by_model, 1.02 * *gradient_of("{}"));  // more than in the gentlest of corners
}

TEST(Handling, CornersAreToldWithWhetherTheWorldAgrees) {
  measured::SteadyTurning logs;
  logs.gradient = 0.001, logs.low = 0.0008, logs.high = 0.0012;
  const std::string under = "In gentle corners the car understeers by 0.56 deg/g (0.45 to 0.67)";
  EXPECT_EQ(corners_text(logs, std::nullopt), under + ".");
  EXPECT_EQ(corners_text(logs, 0.0009), under + "; the world given agrees, it understeers by 0.51 deg/g.");
  EXPECT_EQ(corners_text(logs, 0.0003), under + "; the world given does not agree, it understeers by 0.17 deg/g.");
  EXPECT_EQ(corners_text(logs, -0.001), under + "; the world given does not agree, it oversteers by 0.56 deg/g.");
  logs.gradient = -0.001, logs.low = -0.0012, logs.high = -0.0008;
  EXPECT_EQ(corners_text(logs, -0.0003),
            "In gentle corners the car oversteers by 0.56 deg/g (0.45 to 0.67); the world given does not agree, it "
            "oversteers by 0.17 deg/g.");
}

TEST(Handling, ACarWithoutTyresHasNoGradient) {
  EXPECT_FALSE(gradient_of(R"({"plant": {"plugin": "kinematic", "effects": null, "params": null}})"));
  EXPECT_FALSE(gradient_of(R"({"plant": {"params": {"Df": 0}}})"));  // no steering keeps it in a corner
}

}  // namespace test_handling
}  // namespace gripline::calibrate
