// The line between two edges whose points need not correspond.
#pragma once

#include <cstddef>
#include <vector>

#include "geometry/closed_curve.hpp"
#include "geometry/polyline.hpp"

namespace gripline {

/// How two edges lie to each other, seen from the points of the first.
struct EdgeSides {
  double distance = 0.0;   ///< mean, from one edge to the other
  double left = 0.0;       ///< mean distance of the other edge to the left of this one
  double along = 0.0;      ///< mean cosine between the directions of the two edges
  std::size_t anchor = 0;  ///< a point whose nearest place on the other edge is certainly across the road
  double beside = 0.0;     ///< the station of that place on the other edge
};
EdgeSides compare_edges(const ClosedPolyline& edge, const ClosedPolyline& other);

/// The line between two edges, and which places of both are beside its points.
struct MiddleLine {
  std::vector<PlanePoint> points;
  std::vector<double> on_inner, on_outer;  ///< stations
};

/// The line that is equally far from both edges, every `spacing` metres: from halfway across, every point moves half
/// the difference. `sides`: of the inner edge, compared with the outer one.
MiddleLine middle_line(const ClosedPolyline& inner, const ClosedPolyline& outer, const EdgeSides& sides,
                       double spacing);

/// Where the edges have changed sides they crossed: throws GeometryError with the place of the first such sample of the
/// middle line.
void check_crossing(const ClosedCurve& centre, const MiddleLine& middle, const ClosedPolyline& inner,
                    const ClosedPolyline& outer, bool inner_left);

}  // namespace gripline
