// One closed lap from a trace: what loggers and surveys leave too much or too little of.
#pragma once

#include <string>
#include <vector>

#include "geometry/road_trace.hpp"

namespace gripline {

struct TraceRepair {
  double width = 0.0;        ///< [m] of the road, usually; 0: what follows a lap is not looked for
  bool surveyed = false;     ///< a table of the road or of an edge, not a drive
  double largest_gap = 0.0;  ///< [m] an open line whose ends are at most so far apart is closed
};

/// Makes a closed lap of a trace in the plane that has enough points (require_points): points where a drive stands are
/// left out, what continues beyond the start is cut where it comes back to it, a gap is closed, a last point that
/// repeats the first is left out, heights that drifted a little are evened out. `remarks` gets a line for each change,
/// and one where points seem to be missing (long_steps.hpp).
/// Throws GeometryError where the line stays open, its heights do not meet, or too few points are left.
void repair(RoadTrace& trace, const TraceRepair& how, std::vector<std::string>& remarks);

/// Throws GeometryError where the points are too few for a road.
void require_points(const RoadTrace& trace);

}  // namespace gripline
