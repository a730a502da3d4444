// A closed road: centre line, edges, slope and walls.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "geometry/closed_curve.hpp"
#include "geometry/polyline.hpp"
#include "geometry/station_table.hpp"

namespace gripline {

/// Everything a road is made of. Tables are by station of the centre line.
struct TrackShape {
  std::string name = {};
  ClosedCurve centre;
  StationTable half_width_right = {};  ///< [m] from the centre line to the right edge
  StationTable half_width_left = {};   ///< [m]
  StationTable grade = {};             ///< [rad] > 0 uphill along the direction of travel
  StationTable bank = {};              ///< [rad] > 0: the right side is higher
  StationTable wall_right = std::numeric_limits<double>::infinity();  ///< [m] beyond the right edge
  StationTable wall_left = std::numeric_limits<double>::infinity();   ///< [m] beyond the left edge
  std::optional<Pose> start = {};                                     ///< default: the centre line's first point
  std::optional<ClosedPolyline> points = {};                          ///< as in the file, if the road came from points
  bool bridges = false;  ///< where the road crosses itself at an angle, one of the two passes over the other
  std::vector<std::string> remarks = {};  ///< what of the file was changed, a line each

  /// Largest and smallest half width of either side [m].
  double widest_half() const;
  double narrowest_half() const;
};

/// Where a road passes over itself: the stations of both passes [m].
struct Crossing {
  double first = 0.0, second = 0.0;
  double x = 0.0, y = 0.0;  ///< where the centre lines cross [m]
  double angle = 0.0;       ///< between them, in (0, pi/2] [rad]
  double height = 0.0;      ///< of the second above the first, by the grade [m]
};

/// Immutable after construction. All queries are const, allocate nothing and may be called from several threads at
/// once.
class Track {
 public:
  /// Throws GeometryError if the road crosses or overlaps itself, has no width, bends more sharply than it is wide, or
  /// does not come back to its height. A crossing of at least 30 degrees is a bridge where the heights differ by a
  /// quarter of the least width, or where the shape says bridges.
  explicit Track(TrackShape shape);

  const std::string& name() const { return shape_.name; }
  /// What of the road's file was changed when it was read, a line each.
  const std::vector<std::string>& remarks() const { return shape_.remarks; }
  const ClosedCurve& centre() const { return shape_.centre; }
  double length() const { return length_; }
  double wrap(double s) const { return wrap_periodic(s, length_); }

  /// The centre line at a station.
  CurvePoint at(double s) const { return shape_.centre.at(s); }
  /// Where a place is: station and offset n (left positive). With a hint: see ClosedCurve::locate.
  CurveLocation locate(double x, double y) const { return shape_.centre.locate(x, y); }
  CurveLocation locate(double x, double y, double hint_s) const { return shape_.centre.locate(x, y, hint_s); }
  /// locate() without a hint, for a car that faces `yaw`: where the road passes over itself, the pass whose direction
  /// of travel is nearest to that heading.
  CurveLocation locate(const Pose& pose) const;
  /// Where the road passes over itself, by the first station.
  const std::vector<Crossing>& crossings() const { return crossings_; }

  double half_width_right(double s) const { return shape_.half_width_right.at(s); }
  double half_width_left(double s) const { return shape_.half_width_left.at(s); }
  double grade(double s) const { return shape_.grade.at(s); }
  double bank(double s) const { return shape_.bank.at(s); }
  /// Grade and bank in the axes of a car with heading `yaw` at `place` [rad]. In a turn of constant bank the grade
  /// along a fixed heading changes by kappa sin(bank) per metre, which adds to the car's load (Meusnier).
  struct Slope {
    double grade = 0, bank = 0;
  };
  Slope slope(const CurveLocation& place, double yaw) const;
  /// Smallest right plus left half width of the whole road [m].
  double narrowest() const { return narrowest_; }

  /// Distance beyond the edge on the side of `place` [m]: positive outside, negative inside.
  double beyond_edge(const CurveLocation& place) const;
  bool inside(const CurveLocation& place) const { return beyond_edge(place) <= 0.0; }
  /// Distance to the wall on the side of `place` [m]: zero or negative means hit, infinite where there is no wall.
  double wall_clearance(const CurveLocation& place) const;

  /// Lap fraction in [0, 1): along the polyline of the file's points where there is one, else s / length. `place` is
  /// where (x, y) was located; the polyline is searched around its foot only. Without it the whole line is searched.
  double lap_fraction(double x, double y, const CurveLocation& place) const;
  double lap_fraction(double x, double y) const { return lap_fraction(x, y, locate(x, y)); }

  /// The default start of a world on this road.
  Pose start() const { return start_; }

 private:
  TrackShape shape_;
  double length_ = 0.0;
  double narrowest_ = 0.0;
  std::vector<Crossing> crossings_;
  Pose start_;
};

}  // namespace gripline
