// What a slope does to the load of a car's axles.
#pragma once

#include <algorithm>
#include <cmath>

#include <gripline/plugin.hpp>

namespace gripline::vehicle {

/// Load of both axles over that at rest on a flat road,
///
///   sqrt(1 - sin(grade)^2 - sin(bank)^2) + vx^2 / g kappa sin(bank),
///
/// in a turn whose bank turns with the road: its surface is curved along the car's way by kappa sin(bank) (Meusnier). A
/// Place has not how the grade changes, so that crests and dips are left out. A car that hardly touches the ground any
/// more is given a fifth of its weight, as plans have it (time_optimal/lap_dynamics.hpp).
template <class T>
T slope_load(const Place& at, const T& vx) {
  if (at.grade == 0.0 && at.bank == 0.0) return T(1);
  constexpr double least = 0.2;
  const double along = std::sin(at.grade), across = std::sin(at.bank);
  const T load = std::sqrt(std::max(0.0, 1.0 - along * along - across * across)) +
                 at.direction * at.kappa * across / gravity * (vx * vx);
  return load > T(least) ? load : T(least);
}

}  // namespace gripline::vehicle
