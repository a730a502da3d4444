// The single-track car along a base line: rates per metre of the line instead of per second.
//
//   s'   = (vx cos(xi) - vy sin(xi)) / (1 - n kappa)              1 / s' is the time per metre
//   n'   = vx sin(xi) + vy cos(xi),   xi' = omega - kappa s'
//   vx'  = a + coast(vx) - Ff sin(delta) + vy omega - g sin(grade)
//   vy'  = Fr + Ff cos(delta) - vx omega + g sin(bank)
//   omega' = (Ff lf cos(delta) - Fr lr) m / Iz,   delta' = rate
//   Faxle = D sin(C atan(B slip)),  slip_f = delta - atan((vy + omega lf) / vx),  slip_r = -atan((vy - omega lr) / vx)
//
// Forces are per mass [m/s2]; a is the force of drive and brakes. Sources: the car is eq. (dyn_model) of Kalaria, Lin,
// Dolan; the change of the independent variable as in Lot, Biral (2014), "A curvilinear abscissa approach for the lap
// time optimization of racing vehicles".
#pragma once

#include <cmath>
#include <type_traits>

#include <gripline/types.hpp>

#include "planners/time_optimal/second_order.hpp"
#include "planners/time_optimal/smooth_curve.hpp"

namespace gripline::planning {

/// Lateral force of an axle over the car's mass: D sin(C atan(B slip)) [m/s2].
struct AxleShape {
  double B = 3, C = 1.3, D = 5;
};
struct Tyres {
  AxleShape front, rear;
};
/// Deceleration rolling + drag vx^2 that the nominal model lacks [m/s2, 1/m].
struct Resistance {
  double rolling = 0, drag = 0;
  double at(double v) const { return rolling + drag * v * v; }
};
/// What is learned of a car, or assumed of it.
struct CarBelief {
  Tyres tyres;
  Resistance resistance;
};

/// Indices of a lap's variables: the state at a node, then the controls of the interval that begins there.
enum LapVariable : int { lap_n, lap_xi, lap_vx, lap_vy, lap_omega, lap_delta, lap_a, lap_rate };
inline constexpr int lap_states = 6, lap_variables = 8;

/// The base line over an interval: mean curvature, slope.
struct LapPlace {
  double kappa = 0, grade = 0, bank = 0;
};

template <class T>
struct LapRates {
  T time;                   // per metre of the base line [s/m]
  T state[lap_states];      // d(state)/ds
  T slip_front, slip_rear;  // [rad]
  T front, rear;            // lateral forces over mass [m/s2]
};

template <class T>
T apply(const SmoothCurve& curve, const T& x) {
  double at = 0;
  if constexpr (std::is_same_v<T, double>)
    at = x;
  else
    at = x.v;
  const SmoothCurve::Value y = curve.at(at);
  return chain(y.f, y.slope, y.bend, x);
}

template <class T>
T axle_force(const AxleShape& axle, const T& slip) {
  using std::atan, std::sin;
  return axle.D * sin(axle.C * atan(axle.B * slip));
}

template <class T>
LapRates<T> lap_rates(const Car& car, const Tyres& tyres, const SmoothCurve& coast, const LapPlace& place,
                      const T (&z)[lap_variables]) {
  using std::atan, std::cos, std::sin;
  const T &n = z[lap_n], &xi = z[lap_xi], &vx = z[lap_vx], &vy = z[lap_vy], &omega = z[lap_omega];
  const T& delta = z[lap_delta];
  LapRates<T> r;
  const T cosine = cos(xi), sine = sin(xi);
  r.time = (1.0 - place.kappa * n) / (vx * cosine - vy * sine);
  r.slip_front = delta - atan((vy + car.lf * omega) / vx);
  r.slip_rear = -atan((vy - car.lr * omega) / vx);
  r.front = axle_force(tyres.front, r.slip_front);
  r.rear = axle_force(tyres.rear, r.slip_rear);
  const T along = r.front * sin(delta), across = r.front * cos(delta);
  r.state[lap_n] = (vx * sine + vy * cosine) * r.time;
  r.state[lap_xi] = omega * r.time - place.kappa;
  r.state[lap_vx] = (z[lap_a] + apply(coast, vx) - along + vy * omega - gravity * std::sin(place.grade)) * r.time;
  r.state[lap_vy] = (r.rear + across - vx * omega + gravity * std::sin(place.bank)) * r.time;
  r.state[lap_omega] = (across * car.lf - r.rear * car.lr) * (car.m / car.Iz) * r.time;
  r.state[lap_delta] = z[lap_rate] * r.time;
  return r;
}

}  // namespace gripline::planning
