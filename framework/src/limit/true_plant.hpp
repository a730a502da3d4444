// The car of a world at a constant friction factor, at many instants at once.
#pragma once

#include <span>
#include <vector>

#include "world/friction_factor.hpp"
#include "world/world_spec.hpp"

namespace gripline {

/// Effects with memory (lags, relaxation) are left out: without them the car answers at once and is faster, which a
/// limit may be.
class TruePlant {
 public:
  /// `spec` must outlive the plant and have a vehicle model.
  TruePlant(const WorldSpec& spec, double factor);

  const Car& car() const { return car_; }
  /// Peak lateral force over weight, both axles, at the factor.
  double mu() const { return mu_; }

  /// motion: rows of x, y, yaw, vx, vy, omega; their rates go to `rate`, slopes of the road included.
  template <class T>
  void rates(std::span<const T> motion, std::span<const ActingCommand<T>> command, std::span<const Place> at,
             std::span<T> rate) const;
  /// Acceleration along a straight, without steering [m/s2].
  double acceleration(double v, double d) const;

 private:
  Car car_;
  FrictionFactor friction_;
  Vehicle vehicle_;
  StagedCar model_;
  double mu_ = 0;
};

}  // namespace gripline
