// What a prediction reads of a log: nothing that was not known at its start, but commands up to its time.
#include "calibrate/forecast/forecaster.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "support/calibrate_rig.hpp"
#include "support/forecast_checks.hpp"

namespace gripline::calibrate {
namespace test_forecast_causality {

using test::CalibrateRig;
using test::drive;
using test::stop_and_go;

/// Changes what a prediction must not read, for several ends of what is known, and compares: rows after a start, and
/// commands (and a prescribed speed) after the time of each horizon.
void expect_nothing_later_read(const CalibrateRig& rig, const Session& s, const std::vector<double>& horizons) {
  auto params = rig.forecaster.defaults();
  params[rig.forecaster.index(ForecastParameter::delay_position)] = 0.03;
  params[rig.forecaster.index(ForecastParameter::delay_velocity)] = -0.02;
  params[rig.forecaster.index(ForecastParameter::delay_yaw_rate)] = 0.2;
  Starts starts;
  starts.horizons = horizons;
  for (std::size_t i = 10; i < 600; i += 17) starts.time.push_back(s.t[i]);
  const auto before = rig.predict(s, params, starts);
  std::size_t compared = 0;
  for (const std::size_t last : {20ul, 203ul, 557ul})
    for (std::size_t j = 0; j < horizons.size(); ++j) {
      const double end = s.t[last] + horizons[j] + 1e-9;
      Session changed = s;
      for (std::size_t i = last + 1; i < s.rows(); ++i)
        for (std::size_t c = 0; c < channels; ++c)
          if (c != 3 || !s.prescribed_speed || s.t[i] > end) changed.reading[i * channels + c] = c % 2 == 0 ? NAN : 1e3;
      for (std::size_t i = 0; i < s.rows(); ++i)
        if (s.t[i] > end) changed.command[i] = {-1.0, 0.4};
      const auto after = rig.predict(changed, params, starts);
      for (std::size_t i = 0; i < starts.time.size(); ++i) {
        if (starts.time[i] > s.t[last]) continue;
        for (std::size_t c = 0; c < channels; ++c, ++compared) {
          const std::size_t k = (i * horizons.size() + j) * channels + c;
          ASSERT_EQ(after[k], before[k]) << "start " << starts.time[i] << " + " << horizons[j] << ", channel " << c;
        }
      }
    }
  EXPECT_GT(compared, 100u * horizons.size());
}

/// Commands of loggers that read throttle and steering at paces of their own.
CommandSample<double> commands_in_steps(double t) {
  return {test::weave(0.1 * std::floor(t / 0.1 + 1e-6)).d, test::weave(0.14 * std::floor(t / 0.14 + 1e-6)).delta};
}

TEST(Forecaster, ReadsTheLogBeforeTheStartAndCommandsUpToItsTimeAndNothingElse) {
  const CalibrateRig rig;
  const Session s = drive(rig.vehicle.car(), {.seconds = 20, .noise = 1, .delay = {0.03, 0.0, 0.02, 0.2}});
  expect_nothing_later_read(rig, s, {1.0});
  expect_nothing_later_read(rig, s, {0.02, 0.5, 1.0});
}

measured::BetweenRows read_every(double seconds) {
  return {.used = measured::BetweenRows::Kind::paced, .every = seconds};
}

TEST(Forecaster, ReadsNothingLaterOfCommandsThatAreReadEverySoOften) {
  const CalibrateRig rig;
  Session s = drive(rig.vehicle.car(), {.seconds = 20, .noise = 1, .command = commands_in_steps});
  s.throttle_between = read_every(0.1);
  s.steering_between = read_every(0.14);
  expect_nothing_later_read(rig, s, {0.06, 0.5, 1.0});
}

TEST(Forecaster, ReadsNothingLaterOfASpeedThatIsPrescribed) {
  const CalibrateRig rig;
  Session s = drive(rig.vehicle.car(), {.seconds = 20, .noise = 1, .command = commands_in_steps});
  s.prescribed_speed = true;
  s.steering_between = read_every(0.14);
  for (auto& command : s.command) command.d = 0.0;
  expect_nothing_later_read(rig, s, {0.06, 0.5, 1.0});
  for (std::size_t i = 0; i < s.rows(); ++i)
    if (i % 5 != 0) s.reading[i * channels + 3] = NAN;
  expect_nothing_later_read(rig, s, {0.06, 0.5, 1.0});
}

TEST(Forecaster, ReadsNothingLaterWhereTheCarStands) {
  const CalibrateRig rig;
  Session s = drive(rig.vehicle.car(), {.seconds = 20, .noise = 1, .command = stop_and_go});
  ASSERT_LT(std::abs(s.at(250, 3)), 0.1);
  expect_nothing_later_read(rig, s, {0.06, 0.5, 1.0});
  for (std::size_t i = 0; i < s.rows(); ++i)
    if (i % 5 != 0) s.reading[i * channels] = s.reading[i * channels + 3] = NAN;
  expect_nothing_later_read(rig, s, {0.06, 0.5, 1.0});
}

}  // namespace test_forecast_causality
}  // namespace gripline::calibrate
