// Closed curves that tests of several sources share.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "geometry/closed_curve.hpp"

namespace gripline::test {

/// The place n metres to the left of a point of a curve.
inline PlanePoint beside(const CurvePoint& at, double n) {
  return {at.x - n * std::sin(at.yaw), at.y + n * std::cos(at.yaw)};
}

/// Points at equal angles on an ellipse with these half axes, counter-clockwise.
inline std::vector<PlanePoint> ellipse_points(double a, double b, int count) {
  std::vector<PlanePoint> p;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    p.push_back({a * std::cos(angle), b * std::sin(angle)});
  }
  return p;
}

inline ClosedCurve ellipse(double a, double b, int count) {
  return ClosedCurve::from_points(ellipse_points(a, b, count));
}

/// Two straights of 4 m, two half circles of radius 1 m, counter-clockwise from (0, 0) along x.
inline ClosedCurve stadium() {
  const std::vector<Segment> segments{Segment::line(4.0), Segment::arc(1.0, std::numbers::pi), Segment::line(4.0),
                                      Segment::arc(1.0, std::numbers::pi)};
  return ClosedCurve::from_segments({0.0, 0.0, 0.0}, segments);
}

/// Distance of the nearest of so many points of a curve.
inline double nearest_of(const ClosedCurve& curve, double x, double y, int count) {
  double nearest = INFINITY;
  for (int k = 0; k < count; ++k) {
    const CurvePoint at = curve.at(curve.length() * k / count);
    nearest = std::min(nearest, std::hypot(at.x - x, at.y - y));
  }
  return nearest;
}

}  // namespace gripline::test
