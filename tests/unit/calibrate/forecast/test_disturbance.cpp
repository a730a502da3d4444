#include "calibrate/forecast/disturbance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "support/calibrate_rig.hpp"
#include "support/forecast_checks.hpp"

namespace gripline::calibrate {
namespace test_disturbance {

using test::CalibrateRig;
using test::drive;
using test::some_starts;
using test::worst;

TEST(Forecaster, ADisturbanceIsCarriedOn) {
  // The log's car rolls with more resistance than the model knows: without the disturbance every prediction is too
  // fast.
  const CalibrateRig truth(test::small_car_world(R"({"plant": {"params": {"Cr0": 1.8}}})")), rig;
  const Session s = drive(truth.vehicle.car(), {.seconds = 30});
  const Starts starts = some_starts(s, {1.0});
  auto params = rig.forecaster.defaults();
  params[rig.forecaster.index(ForecastParameter::gain_force)] = 0.0;
  const double without = worst(s, starts, rig.predict(s, params, starts), 3);
  params[rig.forecaster.index(ForecastParameter::gain_force)] = 2.0;
  params[rig.forecaster.index(ForecastParameter::force_tau)] = 30.0;
  EXPECT_LT(worst(s, starts, rig.predict(s, params, starts), 3), 0.3 * without);
}

/// A log of units at these points, turned so.
Session seen_by(Session s, const measured::Frame& pose, const measured::Frame& velocity) {
  const double turned_c = std::cos(velocity.yaw), turned_s = std::sin(velocity.yaw);
  for (std::size_t i = 0; i < s.rows(); ++i) {
    double* const r = s.reading.data() + i * channels;
    const double c = std::cos(r[2]), q = std::sin(r[2]);
    r[0] += pose.x * c - pose.y * q, r[1] += pose.x * q + pose.y * c, r[2] += pose.yaw;
    const double vx = r[3] - velocity.y * r[5], vy = r[4] + velocity.x * r[5];
    r[3] = vx * turned_c + vy * turned_s, r[4] = vy * turned_c - vx * turned_s;
  }
  s.pose = pose;
  s.velocity = velocity;
  return s;
}

TEST(Forecaster, FramesThatTheMapStatesAreShown) {
  const CalibrateRig rig;
  const Session own = drive(rig.vehicle.car(), {.seconds = 20});
  for (const double turned : {0.1, 0.9, -2.0, 3.1}) {
    const Session s = seen_by(own, {0.3, 0.1, 0.2, true, true, true}, {0.2, 0.0, turned, true, true, true});
    const Starts starts = some_starts(s);
    const std::vector<double> predicted = rig.predict(s, rig.forecaster.defaults(), starts);
    EXPECT_LT(worst(s, starts, predicted, 0), 3e-3) << turned;
    EXPECT_LT(worst(s, starts, predicted, 2), 3e-3) << turned;
    EXPECT_LT(worst(s, starts, predicted, 4), 1e-2) << turned;
  }
}

TEST(Forecaster, ASpeedThatIsPrescribedIsReadThroughTheFrameOfItsUnit) {
  const CalibrateRig rig;
  const Session own = drive(rig.vehicle.car(), {.seconds = 20});
  for (const double turned : {0.5, std::numbers::pi}) {
    Session s = seen_by(own, {}, {0.0, 0.0, turned, false, false, true});
    s.prescribed_speed = true;
    for (auto& command : s.command) command.d = 0.0;
    const Starts starts = some_starts(s);
    const std::vector<double> predicted = rig.predict(s, rig.forecaster.defaults(), starts);
    EXPECT_LT(worst(s, starts, predicted, 2), 5e-3) << turned;
    EXPECT_LT(worst(s, starts, predicted, 3), 2e-2) << turned;
  }
}

}  // namespace test_disturbance
}  // namespace gripline::calibrate
