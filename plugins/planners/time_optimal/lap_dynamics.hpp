// The single-track car along a base line: rates per metre of the line instead of per second.
//
//   s'   = (vx cos(xi) - vy sin(xi)) / (1 - n kappa)              1 / s' is the time per metre
//   n'   = vx sin(xi) + vy cos(xi),   xi' = omega - kappa s'
//   vx'  = a + coast(vx) - Ff sin(delta) + vy omega - g sin(grade)
//   vy'  = Fr + Ff cos(delta) - vx omega + g sin(bank)
//   omega' = (Ff lf cos(delta) - Fr lr) m / Iz,   delta' = rate
//   Faxle = N D sin(C atan(B slip)),  N = sqrt(1 - sin(grade)^2 - sin(bank)^2) + curve vx^2 / g
//   slip_f = delta - atan((vy + omega lf) / vx),  slip_r = -atan((vy - omega lr) / vx)
//
// N is times the grip of a place, too. Forces are per mass [m/s2]; a is the force of drive and brakes. N is the load of
// both axles over that at rest on a flat road: a crest of radius R (curve -1 / R) takes m vx^2 / R off. Sources: the
// car is the dynamic model of Kalaria, Lin, Dolan; the change of the independent variable as in Lot, Biral (2014), "A
// curvilinear abscissa approach for the lap time optimization of racing vehicles".
#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>

#include <gripline/types.hpp>

#include "common/vehicle/magic_formula.hpp"
#include "planners/time_optimal/cubic_spline.hpp"
#include "planners/time_optimal/second_order_dual.hpp"

namespace gripline::time_optimal {

using vehicle::AxleTyres;  // lateral forces of the axles over the car's mass [m/s2]
using vehicle::MagicFormula;

/// Friction of the whole car: (D_front + D_rear) / g.
inline double mu_of(const AxleTyres& tyres) { return (tyres.front.D + tyres.rear.D) / gravity; }
/// Tyres of a shape whose peaks together give this mu, in the shape's own proportion.
inline AxleTyres scaled_to(const AxleTyres& shape, double mu) {
  const double factor = mu / mu_of(shape);
  AxleTyres tyres = shape;
  tyres.front.D *= factor;
  tyres.rear.D *= factor;
  return tyres;
}

/// Deceleration rolling + drag vx^2 that the nominal model lacks [m/s2, 1/m].
struct SpecificResistance {
  double rolling = 0, drag = 0;
  double at(double v) const { return rolling + drag * v * v; }
};
/// What is learned of a car, or assumed of it.
struct CarBelief {
  AxleTyres tyres;
  SpecificResistance resistance;
};

/// Indices of a lap's variables: the state at a node, then the controls of the interval that begins there.
enum LapVariable : int { lap_n, lap_xi, lap_vx, lap_vy, lap_omega, lap_delta, lap_a, lap_rate };
inline constexpr int lap_states = 6, lap_variables = 8;

/// The base line over an interval: mean curvature, slope, and the curvature of the road's surface along it, as rad of
/// grade per metre: positive in a dip, negative on a crest. `grip`: friction there over that of the road.
struct LapPlace {
  double kappa = 0, grade = 0, bank = 0, curve = 0, grip = 1;
  bool plain() const { return grade == 0.0 && bank == 0.0 && curve == 0.0 && grip == 1.0; }
};

template <class T>
struct LapRates {
  T time;                   // per metre of the base line [s/m]
  T state[lap_states];      // d(state)/ds
  T slip_front, slip_rear;  // [rad]
  T front, rear;            // lateral forces over mass [m/s2]
  T load;                   // of both axles over the static one, times grip
};

template <class T>
double value_of(const T& x) {
  if constexpr (std::is_same_v<T, double>)
    return x;
  else
    return x.v;
}

/// The value of a curve at x, which may carry derivatives. `curve` is anything whose at(double) gives a value with two
/// derivatives.
template <class Curve, class T>
T apply(const Curve& curve, const T& x) {
  const CubicSpline::Value y = curve.at(value_of(x));
  return chain(y.f, y.slope, y.curvature, x);
}

/// N of the head of this file: the load of both axles over that at rest on a flat road. A car that hardly touches the
/// ground any more is given a fifth of its weight: forces stay differentiable.
template <class T>
T relative_load(const LapPlace& place, const T& vx) {
  constexpr double least = 0.2;
  const double along = std::sin(place.grade), across = std::sin(place.bank);
  const T load = std::sqrt(std::max(0.0, 1.0 - along * along - across * across)) + (place.curve / gravity) * (vx * vx);
  return value_of(load) > least ? load : T(least);
}

/// Slip angle of the front axle of a car that moves forward, vx > 0 [rad].
template <class T>
T forward_front_slip(const T& vx, const T& vy, const T& omega, const T& delta, const Car& car) {
  using std::atan;
  return delta - atan((vy + car.lf * omega) / vx);
}

/// What a grade or a bank pulls [m/s2]: 0 on a flat road, without a sine.
inline double slope_pull(double slope) { return slope == 0.0 ? 0.0 : gravity * std::sin(slope); }

template <class T>
LapRates<T> lap_rates(const Car& car, const AxleTyres& tyres, const CubicSpline& coast, const LapPlace& place,
                      const T (&z)[lap_variables]) {
  using std::atan, std::cos, std::sin;
  const T &n = z[lap_n], &xi = z[lap_xi], &vx = z[lap_vx], &vy = z[lap_vy], &omega = z[lap_omega];
  const T& delta = z[lap_delta];
  LapRates<T> r;
  const T cosine = cos(xi), sine = sin(xi);
  r.time = (1.0 - place.kappa * n) / (vx * cosine - vy * sine);
  r.slip_front = forward_front_slip(vx, vy, omega, delta, car);
  r.slip_rear = -atan((vy - car.lr * omega) / vx);
  r.front = tyres.front.force(r.slip_front);
  r.rear = tyres.rear.force(r.slip_rear);
  r.load = T(1.0);
  if (!place.plain()) {
    r.load = place.grip * relative_load(place, vx);
    r.front = r.load * r.front;
    r.rear = r.load * r.rear;
  }
  const T along = r.front * sin(delta), across = r.front * cos(delta);
  r.state[lap_n] = (vx * sine + vy * cosine) * r.time;
  r.state[lap_xi] = omega * r.time - place.kappa;
  r.state[lap_vx] = (z[lap_a] + apply(coast, vx) - along + vy * omega - slope_pull(place.grade)) * r.time;
  r.state[lap_vy] = (r.rear + across - vx * omega + slope_pull(place.bank)) * r.time;
  r.state[lap_omega] = (across * car.lf - r.rear * car.lr) * (car.m / car.Iz) * r.time;
  r.state[lap_delta] = z[lap_rate] * r.time;
  return r;
}

}  // namespace gripline::time_optimal
