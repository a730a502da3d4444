// Points, poses and angles in the ground plane. Metres and radians, ISO axes (x forward, y left, yaw
// counter-clockwise).
#pragma once

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gripline/periodic.hpp>

namespace gripline {

struct PlanePoint {
  double x = 0.0;
  double y = 0.0;
};

inline double distance(const PlanePoint& a, const PlanePoint& b) { return std::hypot(a.x - b.x, a.y - b.y); }

struct Pose {
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;
};

/// A shape that cannot be built or a place that cannot be used.
/// what() is one line for the user: found, expected, remedy.
class GeometryError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// `angle` [rad] moved by whole turns into (-pi, pi].
inline double wrap_angle(double angle) {
  const double wrapped = std::remainder(angle, 2.0 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

/// `difference` of two stations of a closed line, the short way round: in [-period/2, period/2].
inline double wrap_difference(double difference, double period) { return std::remainder(difference, period); }

}  // namespace gripline
