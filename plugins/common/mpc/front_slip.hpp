// The slip angle up to which the front axle gains side force, as a prediction has it.
//
// Beyond a tyre's peak steering acts the other way round: less lock is more force, and a solver that follows slopes
// stays at full lock. Bounds on slip angles keep cars on the rising side: Beal, Gerdes (2013), "Model predictive
// control for vehicle stabilization at the limits of handling".
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include <gripline/interfaces.hpp>

namespace gripline::mpc {

/// [rad], of a car that moves straight on at vx [m/s], coasting on a flat road: where 99 % of the largest force below
/// the steering's limit are reached, also of a tyre that only levels off. Infinite where that is not clearly below the
/// limit, and for cars without slip.
inline double front_saturation_slip(Prediction& model, const Car& car, double vx) {
  constexpr std::size_t count = 32;
  constexpr double reached = 0.99, clearly = 0.8;
  const double spacing = car.delta_max / count;
  std::array<double, count + 1> force{};  // up to a factor: a rear axle that does not slip turns no car
  double largest = 0;
  for (std::size_t i = 1; i <= count; ++i) {
    State x;
    x.vx = vx;
    x.delta = static_cast<double>(i) * spacing;
    force[i] = model.rates(x, Input{}, Place{}).omega / std::cos(x.delta);
    largest = std::max(largest, force[i]);
  }
  std::size_t i = 1;
  while (i < count && force[i] < reached * largest) ++i;
  const double share = (reached * largest - force[i - 1]) / (force[i] - force[i - 1]);
  const double slip = (static_cast<double>(i - 1) + share) * spacing;
  return largest > 0.0 && slip < clearly * car.delta_max ? slip : std::numeric_limits<double>::infinity();
}

}  // namespace gripline::mpc
