// Roads without the noise of their measurement.
#pragma once

#include "geometry/road_table.hpp"

namespace gripline {

struct Smoothed {
  double moved = 0.0;   ///< largest distance of the road's points from the new centre line [m]
  double raised = 0.0;  ///< largest change of a height [m]
  double wanted = 0.0;  ///< least tolerance that would not keep the line from being the smoothest [m]
};
/// The smoothest line within `tolerance` [m] of the road's points: minimises the squared second differences plus
/// (move / half width^2)^2, so that only waves shorter than about three widths are removed. Points nearer to each other
/// than a hundredth of the width count as one. The edges stay where they are; a trace keeps its width. Half widths then
/// change by at most 1:2 along the road: at a step it is narrowed on the wide side. Heights are smoothed over ten half
/// widths. Throws GeometryError without widths.
Smoothed smooth(RoadTable& road, double tolerance);

/// The tolerance with which smooth() would make a sound road of one that is not [m]; 0: no tolerance would.
double helpful_tolerance(const RoadTable& road);

}  // namespace gripline
