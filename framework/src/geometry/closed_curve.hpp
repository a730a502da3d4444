// A closed curve in the plane, of straights and arcs or a spline: the centre line of a track, a racing line.
#pragma once

#include <span>
#include <variant>

#include "geometry/arc_path.hpp"
#include "geometry/spline.hpp"

namespace gripline {

/// Stations run from 0 to length() and repeat. All queries are const, allocate nothing and may be called from several
/// threads at once. A located place satisfies (x, y) = point(s) + n * (-sin yaw, cos yaw).
class ClosedCurve {
 public:
  /// Straights and arcs; `closure` is the largest gap [m] and heading difference [rad] between the last segment and the
  /// first.
  static ClosedCurve from_segments(const Pose& origin, std::span<const Segment> segments, double closure = 1e-5) {
    return ClosedCurve(ArcPath(origin, segments, closure));
  }
  /// A periodic C2 cubic spline through points that do not repeat the first at the end.
  static ClosedCurve from_points(std::span<const PlanePoint> points) { return ClosedCurve(SplinePath(points)); }

  double length() const {
    return std::visit([](const auto& path) { return path.length(); }, path_);
  }
  double wrap(double s) const { return wrap_periodic(s, length()); }

  CurvePoint at(double s) const {
    return std::visit([s](const auto& path) { return path.at(s); }, path_);
  }

  /// The nearest point of the whole curve.
  CurveLocation locate(double x, double y) const {
    return std::visit([x, y](const auto& path) { return path.locate(x, y); }, path_);
  }

  /// Local search: the nearest point that is reached from station `hint_s` with the distance falling all the way. For a
  /// car that moved a little; does not jump to a neighbouring stretch of road.
  CurveLocation locate(double x, double y, double hint_s) const {
    return std::visit([x, y, hint_s](const auto& path) { return path.locate(x, y, hint_s); }, path_);
  }

  /// The spline, or null if the line is made of straights and arcs.
  const SplinePath* spline() const { return std::get_if<SplinePath>(&path_); }

 private:
  explicit ClosedCurve(ArcPath path) : path_(std::move(path)) {}
  explicit ClosedCurve(SplinePath path) : path_(std::move(path)) {}

  std::variant<ArcPath, SplinePath> path_;
};

}  // namespace gripline
