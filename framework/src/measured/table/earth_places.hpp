// Places on the earth, as satellite receivers write them, on a plane.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "measured/finding.hpp"

namespace gripline::measured {

/// By row; NaN where there is none.
struct EarthPlaces {
  std::vector<double> latitude, longitude;  // [rad]; in an unknown unit where the flag below is false
  bool latitude_unit_is_known = false, longitude_unit_is_known = false;
  std::span<const double> t = {};  // times of the rows [s]; empty: what stands before the first fix is not looked for
};
struct PlanePlaces {
  std::vector<double> x, y;  // [m] to the east and to the north of the first place
};

/// Local tangent plane at the first place on the WGS 84 ellipsoid. 0, 0 is not a place, nor is what stands there before
/// the first fix (placeholder_places.hpp); angles whose unit is not known and that no radians can be are degrees;
/// `findings` says so. `file` and its lines, one for each row, are for messages.
/// Throws InputError: no place at all, a latitude beyond a pole.
PlanePlaces on_plane(EarthPlaces places, const std::filesystem::path& file, std::span<const int> line,
                     std::vector<Finding>& findings);

}  // namespace gripline::measured
