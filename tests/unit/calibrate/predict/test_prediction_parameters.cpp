#include "calibrate/predict/prediction_parameters.hpp"

#include <gtest/gtest.h>

#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace test_prediction_parameters {

using test::CalibrateRig;
using test::small_car_world;

/// Yaw is stated to be 0.12 s late, the delay of velocity is to be found.
measured::LogMap map_with_delays() {
  measured::LogMap map = measured::gripline_map();
  map.channel[static_cast<std::size_t>(measured::Source::yaw)]->delay = 0.12;
  map.channel[static_cast<std::size_t>(measured::Source::vx)]->delay.reset();
  map.channel[static_cast<std::size_t>(measured::Source::vy)]->delay.reset();
  return map;
}

PredictionParameters parameters(const CalibrateRig& rig) {
  return prediction_parameters(rig.tree, rig.spec, map_with_delays(), rig.forecaster);
}

TEST(PredictionParameters, AWorldThatWasNeverFittedIsJudgedByItsModelAlone) {
  const CalibrateRig rig;
  const PredictionParameters found = parameters(rig);
  const auto value = [&](ForecastParameter one) { return found.values[rig.forecaster.index(one)]; };
  EXPECT_EQ(value(ForecastParameter::gain_force), 0.0);
  EXPECT_EQ(value(ForecastParameter::gain_steer), 0.0);
  EXPECT_EQ(value(ForecastParameter::delay_position), 0.0);
  EXPECT_EQ(value(ForecastParameter::delay_yaw), 0.12);
  const std::vector<double> defaults = rig.forecaster.defaults();
  for (const ForecastParameter one : {ForecastParameter::delay_velocity, ForecastParameter::gain_yaw})
    EXPECT_EQ(value(one), defaults[rig.forecaster.index(one)]);
  EXPECT_TRUE(found.moving.empty());
}

TEST(PredictionParameters, AFittedWorldsAreItsOwn) {
  const CalibrateRig rig(small_car_world(R"({"calibration": {"delays": {"yaw": 0.02}}})"));
  Errors errors;
  const std::vector<double> own = parameters_of(rig.tree, rig.forecaster, errors);
  const PredictionParameters found = parameters(rig);
  EXPECT_EQ(found.values, own);
  EXPECT_EQ(found.values[rig.forecaster.index(ForecastParameter::delay_yaw)], 0.02);
  EXPECT_GT(found.values[rig.forecaster.index(ForecastParameter::gain_steer)], 0.0);
  EXPECT_TRUE(found.moving.empty());
}

TEST(PredictionParameters, WhatDiffersFromSessionToSessionMoves) {
  const CalibrateRig rig(small_car_world(R"({
      "unknowns": {"/plant/params/Cm1": {"group": "motor", "sigma": 0.3, "scale": "log", "session": 0.1},
                   "/plant/params/Cm2": {"group": "motor", "sigma": 0.3, "scale": "log"}},
      "calibration": {"errors_at_horizon": {"fitted": {"position_m": [0.2, 0.1, 0.3], "vx_mps": [0.3, 0, 1]}}}})"));
  const PredictionParameters found = parameters(rig);
  ASSERT_EQ(found.moving.size(), 1u);
  EXPECT_EQ(found.moving[0].pointer, "/plant/params/Cm1");
  EXPECT_EQ(found.weighing.scale[measured::Channel::vx], 0.3);
}

TEST(PredictionParameters, ForecastsKeepToOneLane) { EXPECT_EQ(prediction_options(CalibrateRig().spec).lanes, 1u); }

}  // namespace test_prediction_parameters
}  // namespace gripline::calibrate
