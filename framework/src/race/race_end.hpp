// What ends a race. Every loop that drives a world asks here: Simulation, and races that are stepped from outside.
#pragma once

#include <optional>

#include "race/metrics.hpp"
#include "world/world.hpp"

namespace gripline {

class RaceEnd {
 public:
  /// At the start of the race. The world must outlive it.
  explicit RaceEnd(const World& world);

  /// After every step of the world.
  void watch();
  /// How the race has ended: error (the car's state is no longer finite), crashed, finished (after its laps or at its
  /// duration), stuck or timeout, the first of these that holds; empty while it goes on.
  std::optional<Status> status() const;
  /// When the car was last seen to have moved [s].
  double moved_at() const { return moved_.t; }

 private:
  const World& world_;
  struct {
    double x = 0, y = 0, t = 0;
  } moved_;  // where and when
};

}  // namespace gripline
