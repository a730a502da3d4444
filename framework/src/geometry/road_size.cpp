#include "geometry/road_size.hpp"

#include <utility>
#include <vector>

#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline {
namespace {

// Bounds of what is driven, with room: roads of cars in 1:43 are some metres long and 0.2 m wide, airfields 50 m wide.
constexpr double shortest = 3.0, narrowest = 0.05, widest = 60.0;  // [m]
// A circuit of 3 to 25 km is this much longer than wide in whatever unit, if it is one for all.
constexpr double stubbiest = 100.0, slenderest = 4000.0;

}  // namespace

std::string warning_of_size(const RoadTable& road) {
  std::vector<double> widths;
  for (std::size_t i = 0; i < road.size(); ++i) widths.push_back(road.right[i] + road.left[i]);
  const double length = road.length(), width = median(std::move(widths), 0.0);
  const std::string size = format("the road is %.3g m long and usually %.3g m wide", length, width);
  if (length < shortest || (width < narrowest && length <= slenderest * width))
    return size +
           ": are its numbers kilometres? Columns named so (x_km, w_right_km) or --scale 1000 make metres of them";
  if (width < narrowest) return size + ": are its widths in another unit than its points, as kilometres?";
  if (width > widest && length >= stubbiest * width)
    return size + ": are its numbers, or its widths alone, feet or centimetres? Columns named so (x_ft, w_right_ft) " +
           "are read in them";
  if (width > widest)
    return size + ": are its widths in another unit than its points, as feet or centimetres? Columns named so " +
           "(w_right_ft) are read in them";
  return {};
}

}  // namespace gripline
