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

/// The slip at which an axle reaches 99 % of its largest force at slips up to `limit` [rad]: found also of a tyre whose
/// force only levels off. Infinite where that is not clearly below the limit. `force(slip)` is the force times any
/// positive factor; it is 0 without slip.
template <class Force>
double saturation_slip(double limit, const Force& force) {
  constexpr std::size_t count = 32;
  constexpr double reached = 0.99, clearly = 0.8;
  const double spacing = limit / count;
  std::array<double, count + 1> forces{};
  double largest = 0;
  for (std::size_t i = 1; i <= count; ++i) {
    forces[i] = force(static_cast<double>(i) * spacing);
    largest = std::max(largest, forces[i]);
  }
  std::size_t i = 1;
  while (i < count && forces[i] < reached * largest) ++i;
  const double share = (reached * largest - forces[i - 1]) / (forces[i] - forces[i - 1]);
  const double slip = (static_cast<double>(i - 1) + share) * spacing;
  return largest > 0.0 && slip < clearly * limit ? slip : std::numeric_limits<double>::infinity();
}

/// The saturation_slip() [rad] of the front axle of a car that moves straight on at vx [m/s], coasting on a flat road,
/// as the steering angle that is commanded: a model's gain of the steering is in it, and lags have settled.
/// Infinite for models without slip.
inline double front_saturation_slip(Prediction& model, const Car& car, double vx) {
  return saturation_slip(car.delta_max, [&](double slip) {
    State x;
    x.vx = vx;
    x.delta = slip;
    return model.rates(x, Input{}, Place{}).omega / std::cos(x.delta);  // a rear axle that does not slip turns no car
  });
}

/// The saturation_slip() [rad] of the rear axle of a car that slides sideways at vx [m/s] forward, its front wheels
/// commanded to point where it moves so that they give no side force.
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
