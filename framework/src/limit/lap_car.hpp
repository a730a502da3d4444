// What a time-optimal lap asks of a car: its rates, and what its commands may ask of its tyres.
#pragma once

#include <span>

#include "car/staged_car.hpp"

namespace gripline {

class LapCar {
 public:
  virtual ~LapCar() = default;
  virtual const Car& car() const = 0;
  /// Peak lateral force over weight, both axles, where friction is least: the scale of a search.
  virtual double mu() const = 0;
  /// Acceleration along a straight, without steering [m/s2].
  virtual double acceleration(double v, double d) const = 0;
  /// motion: rows of x, y, yaw, vx, vy, omega; their rates go to `rate`, slopes of the road included.
  virtual void lap_rates(std::span<const Dual8> motion, std::span<const ActingCommand<Dual8>> command,
                         std::span<const Place> at, std::span<Dual8> rate) const = 0;
  /// Whether used() is to stay at or below 1: a car without tyres of its own.
  virtual bool bounded() const { return false; }
  /// Share of what the tyres hold that is used at a speed, a yaw rate, a throttle >= 0 and a brake <= 0.
  virtual Dual8 used(const Dual8& /*v*/, const Dual8& /*omega*/, const Dual8& /*throttle*/, const Dual8& /*brake*/,
                     const Place& /*at*/) const {
    return Dual8(0.0);
  }
};

}  // namespace gripline
