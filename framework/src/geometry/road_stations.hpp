// Places along a road at equal steps, found by where they lie in the plane.
#pragma once

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/track.hpp"

namespace gripline {

/// A place on a road's centre line with the half widths there [m].
struct RoadStation {
  CurvePoint centre;
  double right = 0.0, left = 0.0;
};

/// The road's stations from 0 on, every `spacing` [m], or fewer where a road that is wide for its narrowest place would
/// take too long to compare with itself; 64 at least. The half widths are more than 0.
std::vector<RoadStation> road_stations(const TrackShape& shape, double spacing);

/// Stations by squares of the plane. `road` must outlive it.
class StationSquares {
 public:
  /// `size` of a square [m].
  StationSquares(std::span<const RoadStation> road, double size);

  /// Calls visit(index) for every station nearer to a place than `reach`, which is at most the size of the squares, in
  /// no order. All in metres.
  template <class Visit>
  void visit_near(double x, double y, double reach, Visit&& visit) const {
    for (std::int64_t i = column(x) - 1; i <= column(x) + 1; ++i) {
      auto member = std::lower_bound(members_.begin(), members_.end(), Member{i, column(y) - 1, 0});
      for (; member != members_.end() && member->x == i && member->y <= column(y) + 1; ++member) {
        const CurvePoint& at = road_[member->station].centre;
        const double dx = x - at.x, dy = y - at.y;
        if (dx * dx + dy * dy < reach * reach) visit(member->station);
      }
    }
  }

 private:
  struct Member {
    std::int64_t x = 0, y = 0;
    std::size_t station = 0;
    auto operator<=>(const Member&) const = default;
  };
  std::int64_t column(double place) const { return static_cast<std::int64_t>(std::floor(place / size_)); }

  std::span<const RoadStation> road_;
  double size_;
  std::vector<Member> members_;
};

}  // namespace gripline
