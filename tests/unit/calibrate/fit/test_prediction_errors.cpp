#include "calibrate/fit/prediction_errors.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "support/calibrate_rig.hpp"
#include "util/numbers.hpp"

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

/// They say nothing, and one of them would leave a fit no move that is a number.
TEST(PredictionErrors, ErrorsWhoseDerivativesAreNoNumbersAreLeftOut) {
  const test::CalibrateRig rig;
  const measured::Session session = test::drive(rig.vehicle.car(), {.seconds = 20, .noise = 1});
  std::vector<FitLog> logs(1, FitLog(session, 0.02, {1.0}, 0.5, 0.5));
  PredictionErrors errors(rig.forecaster, logs);
  errors.weighing.horizon = {1.0};
  Unknown lasting;  // a disturbance that never fades: its rate is 0, the derivative by its logarithm 0 times infinity
  lasting.index = rig.forecaster.index(ForecastParameter::steer_tau);
  lasting.log = true;
  std::vector<double> params = rig.forecaster.defaults();
  params[lasting.index] = std::numeric_limits<double>::infinity();
  const BlockedNormalEquations found = errors.linearise(params, std::vector<Unknown>{lasting});
  EXPECT_TRUE(std::isfinite(found.cost));
  EXPECT_GT(found.dropped, 0u);
  EXPECT_EQ(found.undefined, found.dropped);
  for (const Eigen::MatrixXd& hessian : found.hessian) EXPECT_TRUE(hessian.allFinite());
}

using measured::Channel;

/// 20 s at 10 m/s straight on; stamps are off an even 0.05 s by up to `jitter` [s].
Session straight(double jitter = 0.0) {
  Session s;
  std::mt19937 random(5);
  s.has.fill(true);
  for (int i = 0; i < 400; ++i) {
    s.t.push_back(0.05 * i + jitter * static_cast<double>(random()) / 4294967296.0);
    for (const double v : {10.0 * s.t.back(), 0.0, 0.0, 10.0, 0.0, 0.0}) s.reading.push_back(v);
    s.command.push_back({0.0, 0.0});
  }
  return s;
}

/// Leaves of a channel each `every`th reading.
void thin(Session& s, std::size_t channel, std::size_t every) {
  for (std::size_t i = 0; i < s.rows(); ++i)
    if (i % every != 0) s.reading[i * channels + channel] = not_a_number;
}

/// Of all starts the share that is compared in a channel.
double compared(const FitLog& log, std::size_t channel) {
  double count = 0.0;
  for (std::size_t k = channel; k < log.truth.size(); k += channels) count += std::isnan(log.truth[k]) ? 0.0 : 1.0;
  return count * static_cast<double>(channels) / static_cast<double>(log.truth.size());
}

FitLog log_of(const Session& s) { return {s, 0.02, {0.5}, 0.1, 1.0}; }

TEST(PredictionErrors, AChannelSlowerThanUnevenRowsIsCompared) {
  Session s = straight(0.01);
  thin(s, Channel::x, 4);
  const FitLog log = log_of(s);
  EXPECT_GT(compared(log, Channel::x), 0.9);
  for (std::size_t i = 0; i < log.starts.time.size(); ++i)
    if (!std::isnan(log.truth[i * channels])) {
      EXPECT_NEAR(log.truth[i * channels], 10.0 * (log.starts.time[i] + 0.5), 1e-9);
    }
  EXPECT_EQ(never_compared(log), "");
}

TEST(PredictionErrors, AnEvenRowWithoutAReadingIsNotCompared) {
  Session s = straight();
  thin(s, Channel::x, 4);
  EXPECT_LT(compared(log_of(s), Channel::x), 0.6);
}

TEST(PredictionErrors, LostReadingsAreNotMadeUp) {
  Session s = straight(0.01);
  const double all = compared(log_of(s), Channel::x);
  s.reading[200 * channels] = not_a_number;
  EXPECT_LT(compared(log_of(s), Channel::x), all);
}

TEST(PredictionErrors, AStartBeforeTheFirstReadingOfAChannelIsNotJudgedByIt) {
  Session s = straight();
  for (std::size_t i = 0; i < 100; ++i) s.reading[i * channels + Channel::yaw] = not_a_number;
  const FitLog log = log_of(s);
  for (std::size_t i = 0; i < log.starts.time.size(); ++i)
    for (const std::size_t c : {Channel::x, Channel::y, Channel::yaw})
      EXPECT_EQ(std::isnan(log.truth[i * channels + c]), log.starts.time[i] < s.t[100] - 1e-6);
  EXPECT_EQ(compared(log, Channel::vx), 1.0);
}

TEST(PredictionErrors, AChannelThatIsNeverComparedIsNamed) {
  Session s = straight(0.01);
  thin(s, Channel::yaw_rate, 20);
  EXPECT_THAT(never_compared(log_of(s)), testing::StartsWith("yaw rate: "));
  s.has[Channel::yaw_rate] = false;
  EXPECT_EQ(never_compared(log_of(s)), "");
}

}  // namespace test_prediction_errors
}  // namespace gripline::calibrate
