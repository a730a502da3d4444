// A road as a drawing.
#pragma once

#include <string>

#include "geometry/track.hpp"

namespace gripline::tools {

/// An SVG of the road from above, y up: edges, centre line, the start with its direction, a scale and every bridge.
std::string picture_of(const Track& track);

}  // namespace gripline::tools
