// The single-track car with known axle forces: its equations of motion in the car's axes, from which estimators learn.
//
//   vx'    = straight - (R + Ff sin(delta)) / m + vy omega
//   vy'    = bank_rate + (Ff cos(delta) + Fr) / m - vx omega
//   omega' = (Ff lf cos(delta) - Fr lr) / Iz
//
// `straight` is vx' from drive, nominal resistance and slope alone, without slip; `bank_rate` is what a bank adds to
// vy'; R is a resistance beside the nominal one.
// Source: Kalaria, Lin, Dolan, the dynamic model of their simulated car.
#pragma once

#include <algorithm>
#include <cmath>

#include <gripline/slip.hpp>
#include <gripline/types.hpp>

namespace gripline::learning {

/// Velocities in the car's axes at the centre of gravity [m/s, m/s, rad/s], or their rates.
struct BodyVelocity {
  double vx = 0, vy = 0, omega = 0;
};
inline BodyVelocity advanced(const BodyVelocity& x, const BodyVelocity& rate, double h) {
  return {x.vx + h * rate.vx, x.vy + h * rate.vy, x.omega + h * rate.omega};
}

/// Slip angles of both axles [rad].
struct Slips {
  double front = 0, rear = 0;
};

/// The forward speed in the slip angles: at least v_min [m/s], so that they stay smooth at standstill.
template <class T>
T slip_speed(const T& vx, double v_min) {
  using std::abs, std::max;
  return max(T(abs(vx)), T(v_min));
}

/// Of a car that drives forward: nothing is learned of one that does not.
inline Slips slips(const BodyVelocity& x, double delta, const Car& car) {
  const double forward = slip_speed(x.vx, car.v_min);
  return {front_slip(forward, x.vy, x.omega, delta, car.lf), rear_slip(forward, x.vy, x.omega, car.lr)};
}

/// Resistance force Cr0 + Cd vx^2 beside the nominal model's own [N, N s2/m2].
struct ResistanceForce {
  double Cr0 = 0, Cd = 0;
};

/// Forces on the axles, positive to the left [N].
struct AxleForces {
  double front = 0, rear = 0;
};

/// Rates of a car under these forces; `resistance` is R [N], `straight` and `bank_rate` are accelerations [m/s2].
inline BodyVelocity body_rates(const BodyVelocity& x, double delta, double straight, double bank_rate,
                               const AxleForces& force, double resistance, const Car& car) {
  const double sine = std::sin(delta), cosine = std::cos(delta);
  return {straight - (resistance + force.front * sine) / car.m + x.vy * x.omega,
          bank_rate + (force.rear + force.front * cosine) / car.m - x.vx * x.omega,
          (force.front * car.lf * cosine - force.rear * car.lr) / car.Iz};
}

/// One step h [s] of the classical Runge-Kutta method for x' = rates(x); advanced(x, rate, h) is x + h rate.
template <class X, class Rates>
X runge_kutta_step(const X& x, double h, const Rates& rates) {
  const X k1 = rates(x), k2 = rates(advanced(x, k1, h / 2)), k3 = rates(advanced(x, k2, h / 2)),
          k4 = rates(advanced(x, k3, h));
  return advanced(advanced(advanced(advanced(x, k1, h / 6), k2, h / 3), k3, h / 3), k4, h / 6);
}

}  // namespace gripline::learning
