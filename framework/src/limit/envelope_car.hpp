// A black box in a time-optimal lap: a point that follows its path within the envelope measured of it.
//
//   v' = throttle(v) d+ + brakes(v) d- + rolling(v) - bend a^2 - g sin(grade),     a = v omega - g sin(bank)
//   omega = v delta / L up to the rate of the steering; vy = 0
//   used = (a / side)^p + (throttle(v) d+ / drive)^p + (brakes(v) d- / brake)^p <= 1
//
// side, drive and brake carry with the road: their part of the weight times  sqrt(1 - sin(grade)^2 - sin(bank)^2) +
// v^2 curve / g, and all of them times the factor of a patch. Where a crest leaves nothing of that, tyres hold 1 % of
// what they do at rest: faster is never less use, and a car in the air can but go straight on. Lags of engine, brakes
// and tyres and the inertia in yaw are left out, without which the car is faster.
#pragma once

#include "limit/lap_car.hpp"
#include "limit/plant_envelope.hpp"
#include "world/world_spec.hpp"

namespace gripline {

class EnvelopeCar final : public LapCar {
 public:
  /// `spec` has a plant plugin and must outlive the car. `patches`: within those of the world's friction tyres hold
  /// less. Drives the plant for some seconds of CPU.
  EnvelopeCar(const WorldSpec& spec, double factor, bool patches);
  /// Takes an envelope that was measured before: drives nothing.
  EnvelopeCar(const WorldSpec& spec, PlantEnvelope envelope, bool patches);

  const Car& car() const override { return spec_.car.car; }
  double mu() const override;
  double acceleration(double v, double d) const override;
  void lap_rates(std::span<const Dual8> motion, std::span<const ActingCommand<Dual8>> command,
                 std::span<const Place> at, std::span<Dual8> rate) const override;
  bool bounded() const override { return true; }
  Dual8 used(const Dual8& v, const Dual8& omega, const Dual8& throttle, const Dual8& brake,
             const Place& at) const override;
  const PlantEnvelope& envelope() const { return envelope_; }

 private:
  template <class T>
  T driven(const T& v, const T& d) const;
  /// Curvature of the road in height along the road, and in a banked turn [1/m].
  double curve_at(double station) const;
  double patch_at(double station) const { return patches_.factor(0, INFINITY, station); }

  const WorldSpec& spec_;
  PlantEnvelope envelope_;
  FrictionSchedule patches_;
  std::vector<double> curve_;  // even over the road
};

}  // namespace gripline
