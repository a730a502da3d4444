// Results of queries to a closed curve.
#pragma once

#include "geometry/plane.hpp"

namespace gripline {

/// A point of a line: station s [m], place [m], heading of the tangent [rad] in (-pi, pi], curvature [1/m] left
/// positive.
struct CurvePoint {
  double s = 0.0;
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;
  double kappa = 0.0;
};

/// Where a place is relative to a line: its foot's station s in [0, length), the signed distance n [m] (left positive;
/// |n| is the distance to the line as a curve), and heading and curvature of the line at the foot.
struct CurveLocation {
  double s = 0.0;
  double n = 0.0;
  double yaw = 0.0;
  double kappa = 0.0;
};

}  // namespace gripline
