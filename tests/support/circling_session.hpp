// A session of a car that goes round a circle of 20 m at 8 m/s, with noise of 5 mm on its places, for tests of what
// reads sessions.
#pragma once

#include <cmath>
#include <cstddef>
#include <random>

#include "measured/session/session.hpp"
#include "util/numbers.hpp"

namespace gripline::test {

/// 60 s in rows of `dt` [s]; places are read in every `every`-th row.
inline measured::Session circling_session(double dt, std::size_t every = 1) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.005);
  measured::Session s;
  constexpr double speed = 8.0, radius = 20.0;
  for (double t = 0.0; t < 60.0; t += dt) {
    const double yaw = speed * t / radius;
    const bool read = s.t.size() % every == 0;
    const double x = radius * std::sin(yaw) + noise(random), y = radius - radius * std::cos(yaw) + noise(random);
    s.t.push_back(t);
    for (const double value : {read ? x : not_a_number, read ? y : not_a_number, yaw, speed, 0.0, speed / radius})
      s.reading.push_back(value);
    s.command.push_back({});
  }
  s.has.fill(true);
  return s;
}

}  // namespace gripline::test
