// Paths of a car with a least turning radius from one pose to another: an arc, then a straight line or an arc of the
// other direction, then an arc.
//
// Source: Dubins (1957), "On curves of minimal length with a constraint on average curvature": the shortest path is one
// of these. For three arcs both choices of the middle one are offered, as the longer may need less room.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace gripline::planning {

struct PlanePose {
  double x = 0, y = 0, yaw = 0;  // [m, m, rad]
};
/// A pose on a path, and the path's curvature there [1/m], positive to the left.
struct PathPoint : PlanePose {
  double curvature = 0;
};

/// Three parts from a pose; the arcs' curvature is +-1 / radius.
class DubinsPath {
 public:
  static constexpr int kinds = 8;

  /// The path of one kind, if there is one: 0 to 3 have a straight line in the middle, and 0 or 1 is always there.
  static std::optional<DubinsPath> between(const PlanePose& from, const PlanePose& to, double radius, int kind) {
    const bool arcs = kind >= 4;
    const double first = kind % 2 == 0 ? 1.0 : -1.0;  // the side of the first arc: left, right
    const double last = arcs || kind < 2 ? first : -first;
    const PlanePose c0 = centre(from, first * radius), c1 = centre(to, last * radius);
    const double apart = std::hypot(c1.x - c0.x, c1.y - c0.y), along = std::atan2(c1.y - c0.y, c1.x - c0.x);
    DubinsPath path;
    path.from_ = from;
    path.curvature_ = {first / radius, arcs ? -first / radius : 0.0, last / radius};
    if (arcs) {
      if (apart > 4.0 * radius) return std::nullopt;
      // The middle circle touches both: its centre is off the line between theirs by this angle, on either side.
      const double side = (kind < 6 ? 1.0 : -1.0) * std::acos(0.25 * apart / radius);
      const double h0 = along + side + first * 0.5 * std::numbers::pi;
      const double h1 = along + std::numbers::pi - side + first * 0.5 * std::numbers::pi;
      path.length_ = {radius * turn(first * (h0 - from.yaw)), radius * turn(-first * (h1 - h0)),
                      radius * turn(first * (to.yaw - h1))};
    } else {
      const double cross = first == last ? 0.0 : 2.0 * radius;
      if (apart < cross) return std::nullopt;
      const double heading = along + (cross > 0.0 ? first * std::asin(cross / apart) : 0.0);
      path.length_ = {radius * turn(first * (heading - from.yaw)), std::sqrt(apart * apart - cross * cross),
                      radius * turn(last * (to.yaw - heading))};
    }
    return path;
  }

  double length() const { return length_[0] + length_[1] + length_[2]; }
  /// The path after `way` metres; beyond its ends it stays as it is there.
  PathPoint at(double way) const {
    PathPoint p{from_, 0.0};
    double left = std::clamp(way, 0.0, length());
    for (std::size_t i = 0; i < length_.size(); ++i) {
      const double part = std::min(left, length_[i]), k = curvature_[i];
      p.curvature = k;
      const double yaw = p.yaw + k * part;
      p.x += k == 0.0 ? part * std::cos(p.yaw) : (std::sin(yaw) - std::sin(p.yaw)) / k;
      p.y += k == 0.0 ? part * std::sin(p.yaw) : (std::cos(p.yaw) - std::cos(yaw)) / k;
      p.yaw = yaw;
      left -= part;
      if (left <= 0.0) break;
    }
    return p;
  }

 private:
  /// Centre of the circle of this radius that a car at p drives; a positive radius is a circle to its left.
  static PlanePose centre(const PlanePose& p, double radius) {
    return {p.x - radius * std::sin(p.yaw), p.y + radius * std::cos(p.yaw), 0.0};
  }
  /// The angle wrapped to [0, 2 pi) [rad]. What lies within rounding of 2 pi is 0: no turn, not a full circle.
  static double turn(double angle) {
    constexpr double whole = 2.0 * std::numbers::pi;
    const double wrapped = angle - whole * std::floor(angle / whole);
    return wrapped > whole - 1e-9 ? 0.0 : wrapped;
  }

  PlanePose from_;
  std::array<double, 3> curvature_{}, length_{};
};

}  // namespace gripline::planning
