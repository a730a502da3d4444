// A closed line made of straights and circular arcs that continue each other's tangent. Every query is exact, whatever
// the radii.
#pragma once

#include <span>
#include <vector>

#include "geometry/curve_types.hpp"

namespace gripline {

/// One piece: a straight (turn = 0) or an arc whose tangent turns by `turn` [rad], left positive.
struct Segment {
  double length = 0.0;  ///< [m] along the line, > 0
  double turn = 0.0;    ///< [rad]

  static Segment line(double length) { return {length, 0.0}; }
  static Segment arc(double radius, double turn) { return {radius * std::abs(turn), turn}; }
};

class ArcPath {
 public:
  /// Throws GeometryError if a segment is empty or if the end misses the start by more than `closure` metres or the
  /// heading by more than `closure` radians.
  ArcPath(const Pose& origin, std::span<const Segment> segments, double closure);

  double length() const { return length_; }
  CurvePoint at(double s) const;
  CurveLocation locate(double x, double y) const;
  CurveLocation locate(double x, double y, double hint_s) const;

 private:
  struct Piece {
    double s = 0.0, length = 0.0;
    double x = 0.0, y = 0.0, yaw = 0.0, cos_yaw = 1.0, sin_yaw = 0.0;
    double kappa = 0.0;                     ///< [1/m], left positive; 0 for a straight
    double centre_x = 0.0, centre_y = 0.0;  ///< of an arc
    bool nearly_straight = false;           ///< an arc whose centre is too far away to measure from
  };
  const Piece& piece_at(double s) const;
  static PlanePoint place_on(const Piece& piece, double along, double turned);
  static double foot(const Piece& piece, double x, double y);
  CurveLocation describe(const Piece& piece, double along, double x, double y) const;

  std::vector<Piece> pieces_;
  std::vector<std::size_t> bucket_;  ///< first piece that reaches into the i-th equal share of the length
  double length_ = 0.0;
};

}  // namespace gripline
