// Where a road's centre line crosses itself, and which of these places are bridges.
#pragma once

#include <span>
#include <vector>

#include "geometry/road_stations.hpp"

namespace gripline {

/// All crossings of one road. To find them takes about as long as to compare the road with itself: for roads that were
/// seen to overlap. Immutable.
class Crossings {
 public:
  /// `road`: the shape's stations at equal steps, from road_stations. Neither is used later.
  explicit Crossings(const TrackShape& shape, std::span<const RoadStation> road);

  /// At 30 degrees or more, where heights differ by clearance() or the shape says that crossings are bridges.
  const std::vector<Crossing>& bridges() const { return bridges_; }
  /// At 30 degrees or more, where nothing says that they are bridges.
  const std::vector<Crossing>& at_grade() const { return at_grade_; }
  /// At too small an angle for a bridge.
  const std::vector<Crossing>& shallow() const { return shallow_; }
  /// A crossing that is no bridge, one at grade first; null where all are bridges.
  const Crossing* no_bridge() const;
  /// Whether the road is in the same place at stations a and b [m] because one passes over the other nearby.
  bool bridge_explains(double a, double b) const;
  /// Difference of heights that makes a crossing a bridge: a quarter of the least width [m].
  double clearance() const { return clearance_; }

 private:
  /// Way from a crossing within which the two passes overlap, and a little more [m].
  double reach(const Crossing& c) const;

  double length_, widest_half_, clearance_;
  std::vector<Crossing> bridges_, at_grade_, shallow_;
};

}  // namespace gripline
