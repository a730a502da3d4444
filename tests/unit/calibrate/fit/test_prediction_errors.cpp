#include "calibrate/fit/prediction_errors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace test_prediction_errors {

constexpr std::size_t yaw = measured::Channel::yaw;

TEST(PredictionErrors, AHeadingThatIsWholeTurnsAwayIsNotOff) {
  const test::CalibrateRig rig;
  const measured::Session session = test::drive(rig.vehicle.car(), {.seconds = 20, .noise = 1});
  std::vector<FitLog> logs(1, FitLog(session, 0.02, {1.0}, 0.5, 0.5)), turned = logs;
  for (std::size_t k = yaw; k < turned.front().truth.size(); k += channels)
    turned.front().truth[k] += 2.0 * std::numbers::pi;
  PredictionErrors as_read(rig.forecaster, logs), with_turn(rig.forecaster, turned);
  as_read.weighing.horizon = with_turn.weighing.horizon = {1.0};
  const std::vector<double> params = rig.forecaster.defaults();
  const std::vector<double> off = as_read.errors(params).front(), other = with_turn.errors(params).front();
  for (std::size_t k = yaw; k < off.size(); k += channels) EXPECT_NEAR(other[k], off[k], 1e-12) << k;
  EXPECT_NEAR(with_turn.cost(params), as_read.cost(params), 1e-9);
  EXPECT_NEAR(with_turn.linearise(params, {}, {}).cost, as_read.linearise(params, {}, {}).cost, 1e-9);
}

}  // namespace test_prediction_errors
}  // namespace gripline::calibrate
