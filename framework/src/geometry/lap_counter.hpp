// Counts laps: a lap ends when the centre of gravity crosses the centre-line normal at the start pose.
#pragma once

#include <optional>

#include "geometry/track.hpp"

namespace gripline {

/// Follows the car's station and the distance it has covered along the centre line since the start. A lap ends at the
/// first forward crossing of the line after the road's whole length was covered, so that rolling back over the line and
/// crossing it again, or waiting on it, counts once. Off the road the car stays with the stretch it came from, until it
/// is more than a whole width off and stands on another one.
class LapCounter {
 public:
  /// Keeps a reference to `track`. The car is at `start` at time `t`.
  LapCounter(const Track& track, const Pose& start, double t = 0.0);

  /// Tells the counter where the car is at `t` [s], later than the last call. Returns the moment at which the car ended
  /// a lap on the way, interpolated linearly between the two positions.
  std::optional<double> advance(double t, double x, double y);

  /// Laps ended so far; the lap now being driven has this number, counted from zero.
  int laps() const { return laps_; }
  /// Distance covered along the centre line since the start [m]; falls when the car goes backwards.
  double covered() const { return covered_; }
  /// Where the car was at the last call, relative to the stretch of road it is driving: what offsets and violations are
  /// measured by.
  const CurveLocation& place() const { return place_; }

 private:
  CurveLocation follow(double x, double y) const;
  double ahead_of_line(double x, double y) const;

  const Track& track_;
  CurvePoint line_;  ///< centre-line point whose normal is the finish line
  CurveLocation place_;
  double covered_ = 0.0;
  double t_ = 0.0, x_ = 0.0, y_ = 0.0;
  int laps_ = 0;
};

}  // namespace gripline
