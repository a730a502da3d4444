// The closed polyline through points in file order, and the lap fraction measured along it.
#pragma once

#include <span>
#include <vector>

#include "geometry/plane.hpp"

namespace gripline {

/// From each point of a closed line to the next, and from the last to the first [m].
std::vector<double> chord_lengths(std::span<const PlanePoint> points);

/// Lap fraction (framework/doc/axes-and-signs.md): s is the chord length accumulated in file order, L the total with
/// the closing chord, f = s(nearest point) / L.
class ClosedPolyline {
 public:
  /// At least three points; a last point equal to the first is dropped.
  explicit ClosedPolyline(std::vector<PlanePoint> points);

  double length() const { return length_; }
  std::span<const PlanePoint> points() const { return points_; }
  /// Chord length from the first point to point i [m].
  double station(std::size_t i) const { return stations_[i]; }
  /// Station [m] of the nearest point of the whole polyline.
  double nearest_station(double x, double y) const;
  /// Station [m] of the nearest point of the part around the chord that begins at point `near`: chords on both sides
  /// are followed while they come closer, and three beyond.
  double nearest_station(double x, double y, std::size_t near) const;
  /// Station [m] of the nearest point that is at most `reach` metres of way from station `around`.
  double nearest_station(double x, double y, double around, double reach) const;
  /// In [0, 1).
  double fraction(double x, double y) const { return as_fraction(nearest_station(x, y)); }
  double fraction(double x, double y, std::size_t near) const { return as_fraction(nearest_station(x, y, near)); }
  /// The point at a station [m], periodic.
  PlanePoint at(double s) const;

 private:
  struct Foot {
    double distance2 = 0.0, station = 0.0;
  };
  Foot foot(std::size_t chord, double x, double y) const;
  std::size_t chord_at(double station) const;
  double as_fraction(double station) const;
  std::vector<PlanePoint> points_;
  std::vector<double> stations_;
  double length_ = 0.0;
};

}  // namespace gripline
