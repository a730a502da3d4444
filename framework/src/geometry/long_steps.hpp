// Steps of a line that are long beside its usual ones: where points of a road may be missing.
#pragma once

#include <span>
#include <string>

#include "geometry/plane.hpp"

namespace gripline {

/// The step that a share of all steps from point to point is at most as long as [m]; 0 of fewer than two points.
double step_quantile(std::span<const PlanePoint> points, double share);

/// Says where a closed line, its last step back to the first point included, has steps longer than the road's usual
/// `width` [m] and than three times what nine tenths of its steps are at most, ten times where it runs straight on:
/// files have fewer points on straights. A step aside by a few widths, as edges have them at pit lanes, is not one.
/// `lines` of the points in their file; without, or where one is 0, the place is said. Empty where nothing is missing.
std::string remark_of_long_steps(std::span<const PlanePoint> points, std::span<const int> lines, double width);

}  // namespace gripline
