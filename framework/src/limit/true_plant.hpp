// The car of a world at a friction factor that does not change with time, at many instants at once.
#pragma once

#include <span>
#include <vector>

#include "limit/lap_car.hpp"
#include "world/friction_factor.hpp"
#include "world/world_spec.hpp"

namespace gripline {

/// Effects with memory (lags, relaxation) are left out: without them the car answers at once and is faster, which a
/// limit may be.
class TruePlant final : public LapCar {
 public:
  /// `spec` must outlive the plant and have a vehicle model. `patches`: within those of the world's friction the factor
  /// is multiplied by theirs, from whatever time on they are there.
  TruePlant(const WorldSpec& spec, double factor, bool patches = false);

  const Car& car() const override { return car_; }
  /// Peak lateral force over weight, both axles, where the factor is least.
  double mu() const override { return mu_; }

  /// motion: rows of x, y, yaw, vx, vy, omega; their rates go to `rate`, slopes of the road included.
  template <class T>
  void rates(std::span<const T> motion, std::span<const ActingCommand<T>> command, std::span<const Place> at,
             std::span<T> rate) const;
  /// Acceleration along a straight, without steering [m/s2].
  double acceleration(double v, double d) const override;
  void lap_rates(std::span<const Dual8> motion, std::span<const ActingCommand<Dual8>> command,
                 std::span<const Place> at, std::span<Dual8> rate) const override {
    rates<Dual8>(motion, command, at, rate);
  }

  double factor_at(double station) const;

 private:
  /// Fills the rates of a batch whose instants all have this friction factor.
  template <class T>
  void rates_at_factor(double factor, CarBatch<T> batch) const;

  Car car_;
  double factor_;
  FrictionSchedule patches_;
  FrictionFactor friction_;
  Vehicle vehicle_;
  StagedCar model_;
  double mu_ = 0;
};

}  // namespace gripline
