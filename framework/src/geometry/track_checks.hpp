// Whether a road can be one, and whether a car can start and fit on it.
#pragma once

#include <string>
#include <vector>

#include "geometry/track.hpp"

namespace gripline {

/// The bridges of a road, by the first station. Throws GeometryError if the road crosses or overlaps itself elsewhere,
/// has no width, bends more sharply than it is wide, does not come back to its height, or is given in no unit of
/// metres. Track's constructor asks it.
std::vector<Crossing> check_shape(const TrackShape& shape);

/// One line saying why `start` cannot be used (off the road, or facing against the direction of travel); empty if it
/// can.
std::string check_start(const Track& track, const Pose& start);

/// One line saying that a car of this width [m] does not fit on the road; empty if it does.
std::string check_car_fits(const Track& track, double car_width);

}  // namespace gripline
