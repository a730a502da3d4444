// The slip angle up to which an axle gains side force, as a prediction has it.
//
// Beyond a tyre's peak steering acts the other way round: less lock is more force, and a solver that follows slopes
// stays at full lock. And where the rear axle slips beyond its own, a front axle that turns the car in spins it. Bounds
// on slip angles keep cars on the rising side: Beal, Gerdes (2013), "Model predictive control for vehicle stabilization
// at the limits of handling".
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include <gripline/interfaces.hpp>

namespace gripline::mpc {

/// [rad]: where 99 % of the largest force below the steering's limit are reached, also of a tyre that only levels off.
/// Infinite where that is not clearly below the limit. `force(slip)` is up to a factor; it is 0 without slip.
template <class Force>
double saturation_slip(double limit, const Force& force) {
  constexpr std::size_t count = 32;
  constexpr double reached = 0.99, clearly = 0.8;
  const double spacing = limit / count;
  std::array<double, count + 1> of{};
  double largest = 0;
  for (std::size_t i = 1; i <= count; ++i) {
    of[i] = force(static_cast<double>(i) * spacing);
    largest = std::max(largest, of[i]);
  }
  std::size_t i = 1;
  while (i < count && of[i] < reached * largest) ++i;
  const double share = (reached * largest - of[i - 1]) / (of[i] - of[i - 1]);
  const double slip = (static_cast<double>(i - 1) + share) * spacing;
  return largest > 0.0 && slip < clearly * limit ? slip : std::numeric_limits<double>::infinity();
}

/// Of the front axle of a car that moves straight on at vx [m/s], coasting on a flat road; infinite for cars without
/// slip.
inline double front_saturation_slip(Prediction& model, const Car& car, double vx) {
  return saturation_slip(car.delta_max, [&](double slip) {
    State x;
    x.vx = vx;
    x.delta = slip;
    return model.rates(x, Input{}, Place{}).omega / std::cos(x.delta);  // a rear axle that does not slip turns no car
  });
}

/// The same of the rear axle of a car that moves askew, with its front wheels along its way.
inline double rear_saturation_slip(Prediction& model, const Car& car, double vx) {
  return saturation_slip(car.delta_max, [&](double slip) {
    State x;
    x.vx = vx;
    x.vy = -std::tan(slip) * vx;
    x.delta = -slip;
    return -model.rates(x, Input{}, Place{}).omega;
  });
}

}  // namespace gripline::mpc
