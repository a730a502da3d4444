#include "geometry/road_stations.hpp"

namespace gripline {

std::vector<RoadStation> road_stations(const TrackShape& shape, double spacing) {
  constexpr double fewest = 64.0, always = 6000.0, most = 400000.0, comparisons = 1e7;
  const double length = shape.centre.length();
  const double bearable = std::clamp(std::sqrt(comparisons * length / shape.widest_half()), always, most);
  const auto count = static_cast<std::size_t>(std::clamp(std::ceil(length / spacing), fewest, bearable));
  std::vector<RoadStation> result(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double s = length * static_cast<double>(i) / static_cast<double>(count);
    result[i] = {shape.centre.at(s), shape.half_width_right.at(s), shape.half_width_left.at(s)};
  }
  return result;
}

StationSquares::StationSquares(std::span<const RoadStation> road, double size) : road_(road), size_(size) {
  members_.reserve(road.size());
  for (std::size_t i = 0; i < road.size(); ++i) {
    const CurvePoint& at = road[i].centre;
    members_.push_back({column(at.x), column(at.y), i});
  }
  std::sort(members_.begin(), members_.end());
}

}  // namespace gripline
