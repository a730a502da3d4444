// What a black box can do, measured by driving it on a plane: full throttle, rolling, full brakes, and turns that
// tighten.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <gripline/dual.hpp>
#include <gripline/interfaces.hpp>

namespace gripline {

/// A smooth curve over speed: uniform cubic B-spline with its control points at v0, v0 + dv, ...; straight beyond them.
struct SpeedCurve {
  double v0 = 0, dv = 1;
  std::vector<double> control;
  template <class T>
  T at(const T& v) const;
};

/// a + b v^2: what tyres hold of the weight, and of the downforce.
struct TyreHold {
  double weight = 0;     ///< [m/s2]
  double downforce = 0;  ///< [1/m]
  template <class T>
  T at(const T& v, double load) const {
    return weight * load + downforce * v * v;
  }
};

/// Accelerations [m/s2] of the path, at one friction factor:
///   v' = throttle(v) d + rolling(v) - bend a^2      d in [0, 1], or  brakes(v) d  with d in [-1, 0]
///   (a / side)^p + (x / along)^p <= 1               a across the path, x the part of the commands
/// `along` is `drive` or `brake`, and all three are what the tyres hold at the speed. `bend` is what turning costs.
struct PlantEnvelope {
  SpeedCurve throttle, rolling, brakes;
  TyreHold side, drive, brake;
  double bend = 0;   ///< [s2/m]
  double shape = 2;  ///< p; 2, a circle, where turns on the brakes say nothing
  double top = 0;    ///< [m/s] speed that full throttle reaches
};

/// Drives the plant. Throws std::runtime_error where it does not move, does not stop or does not turn.
PlantEnvelope measure_envelope(Plant& plant, const Car& car, double dt, double factor);

/// Cubic B-spline of the control points (de Boor's matrix form).
template <class T>
T SpeedCurve::at(const T& v) const {
  const auto last = static_cast<std::ptrdiff_t>(control.size()) - 1;
  const T x = (v - v0) / dv;
  const double whole = std::floor(value(x));
  const auto i = static_cast<std::ptrdiff_t>(std::clamp(whole, -1.0, static_cast<double>(last)));
  const auto point = [&](std::ptrdiff_t k) {
    if (k < 0) return control.front() + static_cast<double>(k) * (control[1] - control[0]);
    if (k > last)
      return control.back() + static_cast<double>(k - last) * (control.back() - control[control.size() - 2]);
    return control[static_cast<std::size_t>(k)];
  };
  const double a = point(i - 1), b = point(i), c = point(i + 1), d = point(i + 2);
  const T t = x - static_cast<double>(i), u = 1.0 - t;
  if (whole < -1.0 || whole > static_cast<double>(last)) return (a + 4.0 * b + c) / 6.0 + 0.5 * (c - a) * t;
  return (a * u * u * u + b * (3.0 * t * t * t - 6.0 * t * t + 4.0) + c * (3.0 * u * u * u - 6.0 * u * u + 4.0) +
          d * t * t * t) *
         (1.0 / 6.0);
}

}  // namespace gripline
