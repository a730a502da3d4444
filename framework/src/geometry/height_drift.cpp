#include "geometry/height_drift.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/curve_types.hpp"
#include "util/numbers.hpp"

namespace gripline {

bool repeats_first(std::span<const PlanePoint> points, std::size_t k) {
  return k > 2 && distance(points[0], points[k]) <
                      0.125 * std::min(distance(points[0], points[1]), distance(points[k - 1], points[k]));
}

std::string take_drift_off(std::span<const PlanePoint> points, std::span<double> heights, double drift) {
  constexpr double most = 0.005;  // of the length
  std::vector<double> way(points.size(), 0.0);
  for (std::size_t i = 1; i < points.size(); ++i) way[i] = way[i - 1] + distance(points[i], points[i - 1]);
  const double length = way.back() + distance(points.front(), points.back());
  const char* const where = drift > 0.0 ? "higher" : "lower";
  if (std::abs(drift) > most * length)
    throw GeometryError(
        format("the heights do not close: after a lap it is %.3g m %s than where it began (up to 0.5 %% of its "
               "length, %.3g m, is evened out)",
               std::abs(drift), where, most * length));
  for (std::size_t i = 1; i < points.size(); ++i) heights[i] -= drift * way[i] / length;
  return format("after a lap it is %.3g m %s than where it began: evened out along the way", std::abs(drift), where);
}

std::string even_out_lap(std::span<const PlanePoint> points, std::span<double> heights, std::size_t k) {
  if (heights.empty() || !repeats_first(points, k)) return {};
  // The repeated point may lie a little before or behind the first: the slope explains that much.
  const double first = distance(points[0], points[1]), last = distance(points[k - 1], points[k]);
  const double slope =
      std::max(std::abs(heights[1] - heights[0]) / first, std::abs(heights[k] - heights[k - 1]) / last);
  const double drift = heights[k] - heights[0];
  if (std::abs(drift) <= slope * distance(points[0], points[k]) + 1e-2 * std::min(first, last)) return {};
  return take_drift_off(points.first(k), heights.first(k), drift);
}

}  // namespace gripline
