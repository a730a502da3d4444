#include "calibrate/fit/calibrated_world.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace test_calibrated_world {

using test::CalibrateRig;

TEST(CalibratedWorld, LatenessIsThatOfTheFitWithItsInterval) {
  const CalibrateRig rig;
  std::vector<double> params(rig.forecaster.params(), 0.0);
  params[rig.forecaster.index(ForecastParameter::delay_yaw)] = 0.1;
  params[rig.forecaster.index(ForecastParameter::delay_yaw_rate)] = 0.3;
  const auto stated = turning_lateness(rig.forecaster, params, {});
  EXPECT_EQ(stated.yaw.value, 0.1);
  EXPECT_EQ(stated.yaw_rate.low, 0.3);
  EXPECT_EQ(stated.yaw_rate.high, 0.3);

  // One unknown may be the lateness of several channels.
  FittedParameter one;
  one.unknown.index = rig.forecaster.index(ForecastParameter::delay_position);
  one.unknown.same.push_back({"", rig.forecaster.index(ForecastParameter::delay_yaw)});
  one.interval.low = 0.05;
  one.interval.high = 0.15;
  FittedParameter other;
  other.unknown.index = rig.forecaster.index(ForecastParameter::delay_yaw_rate);
  other.interval.low = 0.2;
  other.interval.high = 0.4;
  const auto fitted = turning_lateness(rig.forecaster, params, std::vector{one, other});
  EXPECT_EQ(fitted.yaw.low, 0.05);
  EXPECT_EQ(fitted.yaw.high, 0.15);
  EXPECT_EQ(fitted.yaw.value, 0.1);
  EXPECT_EQ(fitted.yaw_rate.low, 0.2);
  EXPECT_EQ(fitted.yaw_rate.high, 0.4);
}

/// What the logs or the map say of a delay starts a fit as near as the user's bounds allow.
TEST(CalibratedWorld, ADelaysPriorStaysWithinTheUsersBounds) {
  const CalibrateRig rig(test::small_car_world(R"({"unknowns": {
    "/calibration/delays/position": {"sigma": 0.1, "low": 0, "high": 0.1},
    "/calibration/delays/yaw": {"sigma": 0.1, "low": 0, "high": 0.3}}})"));
  Errors errors;
  std::vector<double> values = parameters_of(rig.tree, rig.forecaster, errors);
  std::vector<Unknown> unknowns =
      read_unknowns(rig.tree, parameter_places(rig.spec, rig.forecaster), values, {}, errors);
  ASSERT_TRUE(errors.empty());
  measured::LogMap map = measured::gripline_map();
  map.find_delay(0, 0.25);
  map.find_delay(1, 0.25);
  fix_or_start_delays(map, {}, rig.forecaster, rig.tree, values, unknowns);
  for (const auto& [delay, expected] :
       {std::pair(ForecastParameter::delay_position, 0.1), {ForecastParameter::delay_yaw, 0.25}}) {
    const std::size_t index = rig.forecaster.index(delay);
    const auto found = std::ranges::find(unknowns, index, &Unknown::index);
    ASSERT_NE(found, unknowns.end());
    EXPECT_EQ(found->prior, expected);
    EXPECT_EQ(values[index], expected);
  }
}

/// As where a stated delay leaves its unknown to one that was said to be the same.
TEST(CalibratedWorld, AnUnknownThatIsHandedOverStaysWithinItsBounds) {
  const CalibrateRig rig(test::small_car_world(R"({"unknowns": {
    "/calibration/delays/position": {"sigma": 0.1, "low": 0, "high": 0.1},
    "/calibration/delays/yaw": {"same_as": "/calibration/delays/position"}}, "calibration": {"delays": {"yaw": 0}}})"));
  Errors errors;
  std::vector<double> values = parameters_of(rig.tree, rig.forecaster, errors);
  std::vector<Unknown> unknowns =
      read_unknowns(rig.tree, parameter_places(rig.spec, rig.forecaster), values, {}, errors);
  ASSERT_TRUE(errors.empty());
  measured::LogMap map = measured::gripline_map();
  map.find_delay(1, 0.0);
  for (const std::size_t channel : {0u, 1u}) map.channel[channel]->delay = 0.25;
  fix_or_start_delays(map, {}, rig.forecaster, rig.tree, values, unknowns);
  const std::size_t position = rig.forecaster.index(ForecastParameter::delay_position),
                    yaw = rig.forecaster.index(ForecastParameter::delay_yaw);
  EXPECT_EQ(std::ranges::find(unknowns, position, &Unknown::index), unknowns.end());
  const auto left = std::ranges::find(unknowns, yaw, &Unknown::index);
  ASSERT_NE(left, unknowns.end());
  EXPECT_EQ(left->prior, 0.1);
  EXPECT_EQ(values[yaw], 0.1);
  EXPECT_EQ(values[position], 0.25);
}

}  // namespace test_calibrated_world
}  // namespace gripline::calibrate
