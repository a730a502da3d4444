// Whether the size of a road is that of roads.
#pragma once

#include <string>

#include "geometry/road_table.hpp"

namespace gripline {

/// A sentence where a road is shorter, narrower or wider than any that is driven, models' roads included, with the unit
/// that its numbers may have; "" elsewhere. Roads whose length does not fit their width are refused by Track.
std::string warning_of_size(const RoadTable& road);

}  // namespace gripline
