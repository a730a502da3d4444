// A simulated log of a car that weaves and changes its speed, by the equations of `dynamic`,
// for tests of code that reads logs. Sensor readings can be late, in turned axes, and noisy.
#pragma once

#include <cmath>
#include <functional>
#include <random>

#include "car/corrected_model.hpp"
#include "measured/session/session.hpp"

namespace gripline::test {

struct WeavingLog {
  double seconds = 60.0, dt = 0.02;
  double noise = 0.0;             // of every reading, relative to 1 cm, 1 mrad, 1 cm/s, 1 mrad/s
  std::array<double, 4> delay{};  // of position, yaw, velocity, yaw rate [s]
  unsigned seed = 1;
  std::function<CommandSample<double>(double t)> command = {};  // empty: a weave at changing throttle
  double speed = 1.5;                                           // at the start [m/s]
};

inline CommandSample<double> weave(double t) {
  return {0.35 + 0.25 * std::sin(0.5 * t) + 0.1 * std::sin(1.7 * t),
          0.12 * std::sin(1.3 * t) + 0.08 * std::sin(3.1 * t + 1.0)};
}

/// Drives `car` along; rows every dt.
inline measured::Session drive(const StagedCar& car, const WeavingLog& options) {
  constexpr int fine = 4;  // integration steps per row
  const double h = options.dt / fine;
  CorrectedModel model(car, {h, Hold::foh, {find_tableau("rk4"), 1}});
  const auto command = options.command ? options.command : weave;
  State x;
  x.vx = options.speed;
  x.delta = command(0.0).delta;
  Place at;
  model.reset(x, command(0.0).d, at);
  const auto rows = static_cast<std::size_t>(options.seconds / options.dt);
  std::vector<State> fine_states;
  for (std::size_t k = 0; k < (rows + 100) * fine; ++k) {
    fine_states.push_back(x);
    const double t = static_cast<double>(k) * h;
    at.t = t;
    const auto now = command(t), next = command(t + h);
    x = model.advance(x, {next.d, (next.delta - now.delta) / h}, at);
  }
  const auto state_at = [&](double t) {
    const double position = std::clamp(t / h, 0.0, static_cast<double>(fine_states.size() - 2));
    const auto i = static_cast<std::size_t>(position);
    const double w = position - static_cast<double>(i);
    const State &a = fine_states[i], &b = fine_states[i + 1];
    const auto mix = [&](double State::*m) { return a.*m + w * (b.*m - a.*m); };
    return std::array<double, 6>{mix(&State::x),  mix(&State::y),  mix(&State::yaw),
                                 mix(&State::vx), mix(&State::vy), mix(&State::omega)};
  };
  std::mt19937_64 random(options.seed);
  std::normal_distribution<double> normal;
  measured::Session s;
  s.name = "weave";
  s.has.fill(true);
  constexpr std::array<std::size_t, 6> group = {0, 0, 1, 2, 2, 3};
  constexpr std::array<double, 6> unit = {0.01, 0.01, 1e-3, 0.01, 0.01, 1e-3};
  const double latest = 0.5;  // rows begin where every delay has something to show
  for (std::size_t k = 0; k < rows; ++k) {
    const double t = latest + static_cast<double>(k) * options.dt;
    s.t.push_back(t);
    s.command.push_back(command(t));
    for (std::size_t c = 0; c < 6; ++c)
      s.reading.push_back(state_at(t - options.delay[group[c]])[c] + options.noise * unit[c] * normal(random));
    s.written_yaw.push_back(s.reading[k * 6 + 2]);
  }
  return s;
}

}  // namespace gripline::test
