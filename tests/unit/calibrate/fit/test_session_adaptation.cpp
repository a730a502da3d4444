#include "calibrate/fit/session_adaptation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace test_session_adaptation {

using test::CalibrateRig;
using test::drive;
using test::small_car_world;

constexpr SessionWeighing weighing{{0.05, 0.05, 0.05, 0.1, 0.1, 0.2}, 0.25};

/// A session of a car that steers 3 degrees to the left of what the fit found and has a weaker motor.
struct Bench {
  explicit Bench(const char* nominal = "{}")
      : rig(small_car_world(nominal)),
        truth(small_car_world(R"({"plant": {"params": {"Cm1": 10.5},
                                            "effects": [{"plugin": "steer_offset", "params": {"d0": 0.03}}]}})")),
        session(drive(truth.vehicle.car(), {.seconds = 40, .noise = 0.5})) {
    Errors errors;
    params = parameters_of(rig.tree, rig.forecaster, errors);
    for (const ParameterPlace& place : parameter_places(rig.spec, rig.forecaster))
      if (const bool motor = place.pointer == "/plant/params/Cm1"; motor || place.pointer.ends_with("/d0")) {
        Unknown u;
        u.pointer = place.pointer;
        u.index = place.index;
        u.log = motor;
        u.low = place.low;
        u.high = place.high;
        u.session = motor ? 0.15 : 0.02;
        moving.push_back(u);
      }
  }
  FitLog log(const Session& of) const { return {of, rig.forecaster.options().step, {1.0}, 0.5, 0.5}; }
  std::vector<double> predict(const FitLog& log, std::span<const Unknown> with,
                              std::vector<double>* at_end = nullptr) const {
    return predict_session(rig.forecaster, log, params, with, weighing, at_end);
  }

  CalibrateRig rig, truth;
  Session session;
  std::vector<double> params;
  std::vector<Unknown> moving;
};

double rms(const FitLog& log, const std::vector<double>& predicted, std::size_t channel, double from) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < log.starts.time.size(); ++i) {
    const double off = predicted[i * channels + channel] - log.truth[i * channels + channel];
    if (log.starts.time[i] >= from && std::isfinite(off)) sum += off * off, count += 1.0;
  }
  return std::sqrt(sum / count);
}

TEST(SessionAdaptation, TheLogBeforeAStartMovesWhatMayDiffer) {
  const Bench bench;
  ASSERT_EQ(bench.moving.size(), 2u);
  const FitLog log = bench.log(bench.session);
  std::vector<double> at_end;
  const auto fixed = bench.predict(log, {}), moved = bench.predict(log, bench.moving, &at_end);
  for (const std::size_t c : {0u, 2u, 3u, 5u}) EXPECT_LT(rms(log, moved, c, 15), 0.6 * rms(log, fixed, c, 15)) << c;
  EXPECT_NEAR(at_end[bench.moving[0].index], 10.5, 0.5);
  EXPECT_NEAR(at_end[bench.moving[1].index], 0.03, 0.006);
}

/// Of a car that could be ten times as fast this log is a crawl: it is all there is to learn from.
TEST(SessionAdaptation, ACrawlIsFollowedWhereNothingFasterWasDriven) {
  const Bench bench(R"({"car": {"v_ref": 20}})");
  const FitLog log = bench.log(bench.session);
  std::vector<double> at_end;
  const auto fixed = bench.predict(log, {}), moved = bench.predict(log, bench.moving, &at_end);
  EXPECT_LT(rms(log, moved, 0, 15), 0.6 * rms(log, fixed, 0, 15));
  EXPECT_NEAR(at_end[bench.moving[1].index], 0.03, 0.006);
}

TEST(SessionAdaptation, AnErrorThatAWidthMovesFarTellsNoMoreThanOneThatItMovesToTheBendOfTheLoss) {
  Bench bench;
  for (Unknown& u : bench.moving) u.sigma = u.session;
  const Session own = drive(bench.rig.vehicle.car(), {.seconds = 20});
  std::vector<FitLog> logs{bench.log(own)};
  PredictionErrors errors(bench.rig.forecaster, logs);
  errors.weighing.scale.fill(2e-3);  // a width moves the place by centimetres
  errors.weighing.horizon = {1.0};
  const auto told_of_steering = [&](double steep) {
    errors.weighing.steep = steep;
    double sum = 0.0;
    for (const Eigen::MatrixXd& h : errors.linearise(bench.params, bench.moving).hessian)
      sum += h(1, 1) * bench.moving[1].sigma * bench.moving[1].sigma;
    return sum;
  };
  const double most = 9.0 * static_cast<double>(logs.front().truth.size());
  EXPECT_LT(told_of_steering(3.0), most);
  EXPECT_GT(told_of_steering(3.0), 0.05 * most);
  EXPECT_GT(told_of_steering(std::numeric_limits<double>::infinity()), 5.0 * most);
}

TEST(SessionAdaptation, NothingMovesBeyondItsWidthOrWithoutOne) {
  Bench bench;
  for (Unknown& u : bench.moving) u.session *= 0.01;
  const FitLog log = bench.log(bench.session);
  std::vector<double> at_end;
  bench.predict(log, bench.moving, &at_end);
  EXPECT_NEAR(at_end[bench.moving[0].index], bench.params[bench.moving[0].index], 0.05);
  EXPECT_NEAR(at_end[bench.moving[1].index], bench.params[bench.moving[1].index], 0.001);
  bench.moving[1].session = 0.0;
  EXPECT_EQ(session_unknowns(bench.moving).size(), 1u);
  std::vector<double> plain;
  bench.rig.forecaster.run<double>(bench.session, log.commands, nullptr, bench.params, log.starts, plain);
  EXPECT_EQ(bench.predict(log, {}), plain);
}

TEST(SessionAdaptation, NothingThatFollowsAStartTouchesItsPrediction) {
  const Bench bench;
  constexpr double last = 24.0;
  Session changed = bench.session;
  for (std::size_t i = 0; i < changed.rows(); ++i) {
    if (changed.t[i] > last)
      for (std::size_t c = 0; c < channels; ++c) changed.reading[i * channels + c] = 3.0 + static_cast<double>(c);
    if (changed.t[i] > last + 1.0 + 1e-9) changed.command[i] = {-1.0, 0.3};
  }
  FitLog before = bench.log(bench.session), after = bench.log(changed);
  const auto whole = bench.predict(before, bench.moving), again = bench.predict(after, bench.moving);
  std::size_t compared = 0;
  for (std::size_t i = 0; i < before.starts.time.size() && before.starts.time[i] <= last; ++i)
    for (std::size_t c = 0; c < channels; ++c, ++compared)
      EXPECT_EQ(whole[i * channels + c], again[i * channels + c]) << before.starts.time[i];
  EXPECT_GT(compared, 200u);
}

TEST(SessionAdaptation, ErrorsAreWeighedAsTheFitLeftThem) {
  EXPECT_FALSE(session_weighing(small_car_world()));
  const auto found = session_weighing(small_car_world(R"({"calibration": {"errors_at_horizon": {"fitted": {
      "position_m": [0.2, 0.1, 0.3], "yaw_rad": [0.1, 0, 1], "vx_mps": [0.3, 0, 1], "yaw_rate_radps": [0.4, 0, 1]}}}})"));
  ASSERT_TRUE(found);
  EXPECT_NEAR(std::hypot(found->scale[0], found->scale[1]), 0.2, 1e-12);
  EXPECT_EQ(found->scale[2], 0.1);
  EXPECT_EQ(found->scale[3], 0.3);
  EXPECT_EQ(found->scale[4], 1.0);  // not recorded
  EXPECT_EQ(found->scale[5], 0.4);
}

}  // namespace test_session_adaptation
}  // namespace gripline::calibrate
