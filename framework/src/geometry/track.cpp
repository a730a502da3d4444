#include "geometry/track.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/track_checks.hpp"

namespace gripline {
namespace {

/// The sum of two tables that are linear between their stations is least at a station of one of them.
double narrowest_width(const TrackShape& shape) {
  const StationTable &left = shape.half_width_left, &right = shape.half_width_right;
  double narrowest = left.at(0.0) + right.at(0.0);
  for (const StationTable* table : {&left, &right})
    for (const double s : table->stations()) narrowest = std::min(narrowest, left.at(s) + right.at(s));
  return narrowest;
}

}  // namespace

double TrackShape::widest_half() const { return std::max(half_width_right.maximum(), half_width_left.maximum()); }
double TrackShape::narrowest_half() const { return std::min(half_width_right.minimum(), half_width_left.minimum()); }

Track::Track(TrackShape shape)
    : shape_(std::move(shape)), length_(shape_.centre.length()), crossings_(check_shape(shape_)) {
  narrowest_ = narrowest_width(shape_);
  const CurvePoint first = shape_.centre.at(0.0);
  start_ = shape_.start.value_or(Pose{first.x, first.y, first.yaw});
}

CurveLocation Track::locate(const Pose& pose) const {
  CurveLocation best = locate(pose.x, pose.y);
  const auto askew = [&](const CurveLocation& at) { return std::abs(wrap_angle(pose.yaw - at.yaw)); };
  for (const Crossing& c : crossings_)
    for (const double s : {c.first, c.second}) {
      const CurveLocation other = locate(pose.x, pose.y, s);
      if (inside(other) && askew(other) < askew(best)) best = other;
    }
  return best;
}

double Track::beyond_edge(const CurveLocation& place) const {
  return place.n >= 0.0 ? place.n - half_width_left(place.s) : -place.n - half_width_right(place.s);
}

Track::Slope Track::slope(const CurveLocation& place, double yaw) const {
  const double cosine = std::cos(yaw - place.yaw), sine = std::sin(yaw - place.yaw);
  const double up = std::sin(shape_.grade.at(place.s)), across = std::sin(shape_.bank.at(place.s));
  const auto angle = [](double part) { return std::asin(std::clamp(part, -1.0, 1.0)); };
  return {angle(up * cosine - across * sine), angle(up * sine + across * cosine)};
}

double Track::wall_clearance(const CurveLocation& place) const {
  return (place.n >= 0.0 ? shape_.wall_left : shape_.wall_right).at(place.s) - beyond_edge(place);
}

double Track::lap_fraction(double x, double y, const CurveLocation& place) const {
  const SplinePath* spline = shape_.centre.spline();
  if (shape_.points && spline != nullptr) return shape_.points->fraction(x, y, spline->knot_before(place.s));
  const double f = place.s / length_;
  return f < 1.0 ? f : 0.0;
}

}  // namespace gripline
