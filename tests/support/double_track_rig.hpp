// What the tests of the double-track car share: a plane road, steady driving, sums of power, refusals.
#pragma once

#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>

#include "plants/double_track/car.hpp"

namespace gripline::double_track {

/// A plane, the same everywhere unless `factor_at` says otherwise.
struct Road final : Ground {
  double grade = 0, bank = 0, factor = 1;
  std::function<double(double x, double y)> factor_at;
  Patch at(double x, double y, double) const override { return {grade, bank, factor_at ? factor_at(x, y) : factor}; }
};

inline constexpr double control_step = 0.02;

inline State rolling(double speed) {
  State x;
  x.vx = speed;
  return x;
}

/// Nothing but tyres and inertia: no drag, no rolling resistance, no downforce, an engine without drag.
inline Params bare() {
  static constexpr std::array<double, 6> engine{84, 500, 0, 740, 500, 0};
  Params p;
  p.drag = p.rolling = p.downforce_front = p.downforce_rear = 0;
  p.engine_torque = {engine.data(), 2, 3};
  return p;
}

inline double effective_mass(const Params& p) { return p.m + 4.0 * p.wheel_inertia / (p.radius * p.radius); }

inline void drive(DoubleTrackCar& car, double d, double delta, double seconds, const Ground& road) {
  const int steps = static_cast<int>(std::lround(seconds / control_step));
  for (int k = 0; k < steps; ++k) car.advance(d, delta, control_step, road);
}

/// Holds speed and yaw rate on a circle until nothing changes; returns the steering angle.
inline double settle_on_circle(DoubleTrackCar& car, double speed, double radius, const Ground& road) {
  car.reset(rolling(speed), road);
  double delta = 2.64 / radius;
  double d = 0.0;
  for (int k = 0; k < 3000; ++k) {
    const Motion& z = car.motion();
    d = std::clamp(d + 0.004 * (speed - z.vx), -0.2, 1.0);
    delta += 0.002 * (speed / radius - z.omega);
    car.advance(std::clamp(d + 0.3 * (speed - z.vx), -1.0, 1.0), delta, control_step, road);
  }
  return delta;
}

inline double energy(const DoubleTrackCar& car) {
  const Motion& z = car.motion();
  const Params& p = car.params();
  double sum = 0.5 * p.m * (z.vx * z.vx + z.vy * z.vy) + 0.5 * p.Iz * z.omega * z.omega;
  for (const double spin : z.spin) sum += 0.5 * p.wheel_inertia * spin * spin;
  return sum;
}

struct Power {
  double in = 0, out = 0;  // from engine and gravity; into brakes, tyres, air [W]
};
inline Power power(const DoubleTrackCar& car, const Road& road) {
  const Motion& z = car.motion();
  const Params& p = car.params();
  const double speed = std::hypot(z.vx, z.vy);
  Power sum;
  sum.in = p.m * gravity * (std::sin(road.bank) * z.vy - std::sin(road.grade) * z.vx);
  sum.out = p.drag * speed * speed * speed;
  for (std::size_t i = 0; i < wheels; ++i) {
    const WheelLoads& w = car.loads()[i];
    sum.in += w.drive * z.spin[i];
    sum.out += w.resistance * z.spin[i] + w.Fx * (p.radius * z.spin[i] - w.Vx) - w.Fy * w.Vy;
  }
  return sum;
}

/// Why a car refuses these parameters.
inline std::string complaint(const std::function<void(Params&)>& change) {
  Params p;
  change(p);
  try {
    const DoubleTrackCar car(p);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "nothing";
}

}  // namespace gripline::double_track
