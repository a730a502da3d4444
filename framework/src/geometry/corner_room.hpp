// Whether the corners of a car stay on a road where its centre of gravity gets round.
#pragma once

#include <gripline/types.hpp>

#include "geometry/track.hpp"

namespace gripline {

/// The corner of a car that comes farthest beyond an edge on a lap.
struct FarthestCorner {
  double beyond = 0.0;  ///< [m] outside the road; 0 and less: every corner stays inside
  double s = 0.0;       ///< [m] station of the centre of gravity there
};

/// The lap on which a car's corners stay best inside, of those tried: the centre line, where the car can steer along
/// it, and lines of least curvature, ever farther from the edges that corners come beyond. The car rolls without slip.
/// It must fit and turn (check_car_fits, check_car_turns), else this may throw GeometryError.
FarthestCorner farthest_corner(const Track& track, const Car& car);

}  // namespace gripline
