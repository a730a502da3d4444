// Derivatives of predictions by parameters of the car, of frames and of delays.
#include "calibrate/forecast/forecaster.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <gripline/plugin.hpp>

#include "calibrate/fit/unknowns.hpp"
#include "support/calibrate_rig.hpp"
#include "support/forecast_checks.hpp"

namespace gripline::calibrate {
namespace test_forecast_derivatives {

using test::CalibrateRig;
using test::drive;
using test::some_starts;

constexpr const char* frames_and_delay = R"({"plant": {"effects": [{"plugin": "input_delay", "params": {"T": 0.03}},
  {"plugin": "pose_lever", "params": {"px": 0.05, "py": 0.01}}, {"plugin": "pose_yaw", "params": {"a": 0.04}},
  {"plugin": "velocity_lever", "params": {"px": 0.03, "py": -0.02}},
  {"plugin": "velocity_yaw", "params": {"a": -0.03}}]}})";

std::size_t index_of(const CalibrateRig& rig, const std::string& pointer) {
  for (const ParameterPlace& place : parameter_places(rig.spec, rig.forecaster))
    if (place.pointer == pointer) return place.index;
  throw std::invalid_argument(pointer);
}

/// Predictions with their derivatives by one parameter.
std::vector<Dual8> differentiate(const CalibrateRig& rig, const Session& s, const std::vector<double>& params,
                                 std::span<const std::size_t> by, const Starts& starts) {
  std::vector<Dual8> seeded(params.begin(), params.end()), predicted;
  for (const std::size_t index : by) seeded[index].d[0] = 1.0;
  rig.forecaster.run<Dual8>(s, measured::CommandGrid(s, 0.02), nullptr, seeded, starts, predicted);
  return predicted;
}

TEST(Forecaster, DerivativesAreThoseOfThePredictions) {
  const CalibrateRig rig;
  const Session s = drive(rig.vehicle.car(), {.seconds = 12, .noise = 1, .delay = {0.0, 0.0, 0.0, 0.1}});
  const Starts starts = some_starts(s);
  std::vector<double> params = rig.forecaster.defaults();
  for (std::size_t g = 0; g < 4; ++g) params[rig.forecaster.index(ForecastParameter::delay_position) + g] = 0.007;
  params[rig.forecaster.index(ForecastParameter::delay_yaw_rate)] = 0.093;
  params[4] *= 1.1;
  const measured::CommandGrid commands(s, 0.02);
  for (std::size_t first = 0; first < params.size(); first += 8) {
    std::vector<Dual8> seeded(params.begin(), params.end()), predicted;
    const std::size_t last = std::min(first + 8, params.size());
    for (std::size_t p = first; p < last; ++p) seeded[p].d[p - first] = 1.0;
    rig.forecaster.run<Dual8>(s, commands, nullptr, seeded, starts, predicted);
    ASSERT_FALSE(predicted.empty());
    for (std::size_t p = first; p < last; ++p) {
      const double step = 1e-5 * std::max(0.1, std::abs(params[p]));
      std::vector<double> up = params, down = params;
      up[p] += step;
      down[p] -= step;
      const auto high = rig.predict(s, up, starts), low = rig.predict(s, down, starts);
      for (std::size_t k = 0; k < predicted.size(); ++k) {
        const double slope = (high[k] - low[k]) / (2 * step);
        EXPECT_NEAR(predicted[k].d[p - first], slope, 1e-4 * (1.0 + std::abs(slope))) << "parameter " << p << ", " << k;
      }
    }
  }
}

TEST(Forecaster, DerivativesByFramesHoldWhereTheCarHardlyMoves) {
  const CalibrateRig rig(test::small_car_world(frames_and_delay));
  const Session s = drive(rig.vehicle.car(),
                          {.seconds = 14, .noise = 1, .command = [](double t) {
                             return CommandSample<double>{std::fmod(t, 6.0) < 3.0 ? 0.4 : -0.2, 0.2 * std::sin(2 * t)};
                           }});
  Starts slow{{}, {0.25, 0.5}}, fast{{}, {0.25, 0.5}};
  for (std::size_t i = 150; i + 60 < s.rows(); i += 9) (s.at(i, 3) < 0.3 ? slow : fast).time.push_back(s.t[i]);
  ASSERT_GT(slow.time.size(), 5u);
  ASSERT_GT(fast.time.size(), 5u);
  const std::vector<double> params = rig.forecaster.defaults();
  const std::size_t velocities = index_of(rig, "/plant/effects/velocity_lever/params/px");
  std::size_t compared = 0, off = 0;
  for (const char* name : {"pose_lever/params/px", "pose_lever/params/py", "pose_yaw/params/a",
                           "velocity_lever/params/px", "velocity_lever/params/py", "velocity_yaw/params/a"}) {
    const std::size_t p = index_of(rig, std::string("/plant/effects/").append(name));
    for (const Starts& starts : {slow, fast}) {
      const auto predicted = differentiate(rig, s, params, std::span(&p, 1), starts);
      constexpr double step = 1e-5;
      std::vector<double> up = params, down = params;
      up[p] += step;
      down[p] -= step;
      const auto high = rig.predict(s, up, starts), low = rig.predict(s, down, starts);
      for (std::size_t k = 0; k < predicted.size(); ++k, ++compared) {
        const double slope = (high[k] - low[k]) / (2 * step);
        const bool close = std::abs(predicted[k].d[0] - slope) < 1e-3 * (1.0 + std::abs(slope));
        off += !close;
        if (p < velocities) {
          EXPECT_TRUE(close) << name << ", " << k;
        }
      }
    }
  }
  // A sideways velocity that a car near standstill starts with grows stiffly: some predictions have a kink there, up to
  // one in twenty by the last digits of the states. Without the derivatives six in ten are off.
  EXPECT_LT(off, compared / 10);
}

/// The cost moves as its derivative says: a jump would be a move that no slope explains.
TEST(Forecaster, NothingJumpsWhereADelayChanges) {
  const CalibrateRig rig(test::small_car_world(frames_and_delay));
  const Session s = drive(rig.vehicle.car(), {.seconds = 14, .noise = 1, .delay = {0.02, 0.02, 0.02, 0.06}});
  const Starts starts = some_starts(s);
  using enum ForecastParameter;
  const auto at = [&](ForecastParameter delay) { return rig.forecaster.index(delay); };
  const std::vector<std::vector<std::size_t>> delays = {
      {at(delay_position), at(delay_yaw), at(delay_velocity), at(delay_yaw_rate)},
      {at(delay_position)},
      {at(delay_velocity)},
      {at(delay_yaw_rate)},
      {index_of(rig, "/plant/effects/input_delay/params/T")}};
  for (const auto& moved : delays) {
    constexpr double step = 5e-4;  // [s], over two steps of the car and two rows
    double worst = 0.0, steepest = 0.0, cost_before = 0.0, slope_before = 0.0;
    for (int i = 0; i <= 90; ++i) {
      std::vector<double> params = rig.forecaster.defaults();
      for (const std::size_t p : moved) params[p] = 2e-4 + i * step;
      const auto predicted = differentiate(rig, s, params, moved, starts);
      double cost = 0.0, slope = 0.0;
      for (std::size_t k = 0; k < predicted.size(); ++k) {
        const double off = predicted[k].v - s.interpolate(k % channels, starts.time[k / channels / 2] +
                                                                            starts.horizons[k / channels % 2]);
        cost += off * off;
        slope += 2.0 * off * predicted[k].d[0];
      }
      if (i > 0) worst = std::max(worst, std::abs(cost - cost_before - 0.5 * step * (slope + slope_before)));
      steepest = std::max(steepest, step * std::abs(slope));
      cost_before = cost, slope_before = slope;
    }
    EXPECT_LT(worst, 0.05 * steepest) << "delay " << moved.front() << ", " << moved.size() << " together";
  }
}

}  // namespace test_forecast_derivatives
}  // namespace gripline::calibrate
