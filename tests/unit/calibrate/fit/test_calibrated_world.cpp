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

}  // namespace test_calibrated_world
}  // namespace gripline::calibrate
