// Heights that drift within a lap, as those of barometers do: where the lap closes they would be a cliff.
#pragma once

#include <span>
#include <string>

#include "geometry/plane.hpp"

namespace gripline {

/// Whether a later point k repeats the first: it is nearer to it than an eighth of both steps beside.
bool repeats_first(std::span<const PlanePoint> points, std::size_t k);

/// Takes `drift`, by how much a lap ends higher than it began [m], off the heights of a closed line along its way, and
/// says so. Throws GeometryError where that is more than 0.5 % of the line's length.
std::string take_drift_off(std::span<const PlanePoint> points, std::span<double> heights, double drift);

/// Where point k repeats the first, but not its height: evens out the heights of the k points of that lap and says so.
/// Empty where nothing is to be done. Throws GeometryError as take_drift_off().
std::string even_out_lap(std::span<const PlanePoint> points, std::span<double> heights, std::size_t k);

}  // namespace gripline
