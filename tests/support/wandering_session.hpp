// A session of a car that wanders at 11 to 19 m/s, with every channel on time and without noise until a test changes it.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "measured/session/session.hpp"

namespace gripline::test {

/// `change` edits each row before it is written: (t [s], number of the row, its six readings, its command, yaw rate
/// [rad/s] and speed [m/s] as functions of time).
template <class Change>
measured::Session wandering(Change change, double seconds = 200.0, double dt = 0.04) {
  measured::Session s;
  s.has.fill(true);
  double x = 0, y = 0, yaw = 0;
  const auto n = static_cast<std::size_t>(seconds / dt);
  const auto rate_at = [](double t) { return 0.2 * std::sin(0.7 * t) + 0.1 * std::sin(2.3 * t + std::sin(0.1 * t)); };
  const auto speed_at = [](double t) { return 15.0 + 3.0 * std::sin(0.4 * t) + std::sin(1.9 * t); };
  for (std::size_t k = 0; k < n; ++k) {
    const double t = static_cast<double>(k) * dt;
    std::array<double, 6> row{x, y, yaw, speed_at(t), 0.0, rate_at(t)};
    CommandSample<double> command{0.3, 2.6 * rate_at(t) / speed_at(t)};
    change(t, k, row, command, rate_at, speed_at);
    s.t.push_back(t);
    s.reading.insert(s.reading.end(), row.begin(), row.end());
    s.command.push_back(command);
    const double middle = t + 0.5 * dt, heading = yaw + 0.5 * dt * rate_at(middle);
    x += dt * speed_at(middle) * std::cos(heading);
    y += dt * speed_at(middle) * std::sin(heading);
    yaw += dt * rate_at(middle);
  }
  return s;
}

inline constexpr auto as_it_is = [](double, std::size_t, auto&, auto&, auto&, auto&) {};

}  // namespace gripline::test
