// Side force of an axle under drive or brake force Fx: reduced by the factor sqrt(1 - (Fx / (ratio Fy_max))^2).
// Source: Pacejka, Tyre and Vehicle Dynamics (2012), section 1.3.
#pragma once

#include <algorithm>
#include <cmath>
#include <tuple>

#include <gripline/plugin.hpp>

namespace gripline::learning {

/// Largest side forces of the axles at static load, as believed [N].
struct PeakForces {
  double front = 1, rear = 1;
};

struct FrictionEllipse {
  double ratio = 0;                         // largest Fx over largest Fy; 0: forces do not share friction
  double drive_front = 0, brake_front = 0;  // front shares of the drive and of the brake force

  /// Share of the side force that an axle keeps under the car's drive force [N]. `load` is the axle's load relative to
  /// the static one, `peak` its largest side force at static load [N].
  template <class T>
  T side_share(Axle axle, const T& drive_force, const T& load, double peak) const {
    using std::max, std::sqrt;
    if (!(ratio > 0.0) || !(load > T(0))) return T(1);  // without load there is no side force to share
    const double front = drive_force < T(0) ? brake_front : drive_front;
    const T used = drive_force * (axle == Axle::front ? front : 1.0 - front) / (load * (ratio * peak));
    return sqrt(max(T(1) - used * used, T(least)));
  }
  static constexpr double least = 0.04;  // of the square: wheels are kept from locking and spinning
};

/// Declarations of an estimator's members ellipse, drive_front, brake_front.
template <class P>
constexpr auto ellipse_parameters() {
  return std::tuple{
      param("ellipse", &P::ellipse, "1", {0, 5},
            "largest drive or brake force over largest side force of a tyre; 0: they do not share friction"),
      param("drive_front", &P::drive_front, "1", {0, 1}, "front share of the drive force"),
      param("brake_front", &P::brake_front, "1", {0, 1}, "front share of the brake force")};
}

}  // namespace gripline::learning
