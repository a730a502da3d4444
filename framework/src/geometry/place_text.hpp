// A place of the plane in messages.
#pragma once

#include <string>

namespace gripline {

/// "(79.78, 0)": coordinates [m] with so many significant digits at most. One that is zero but for rounding, beside a
/// metre or beside the other one, is written as 0.
std::string place_text(double x, double y, int digits = 4);

}  // namespace gripline
