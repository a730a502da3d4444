// Periodic cubic splines: one function, and a closed plane curve measured by its own arc length.
#pragma once

#include <span>
#include <vector>

#include "geometry/curve_types.hpp"

namespace gripline {

/// Slopes m_i at the knots of the periodic C2 cubic that passes through values_i; interval i leads from knot i to knot
/// i+1 (the last back to the first) and has width widths_i > 0. At least three knots.
std::vector<double> periodic_spline_slopes(std::span<const double> values, std::span<const double> widths);

/// A closed C2 curve through points (periodic cubic spline over chord length), queried by true arc length.
class SplinePath {
 public:
  /// At least four points, no two neighbours equal, the first not repeated at the end; else throws GeometryError.
  explicit SplinePath(std::span<const PlanePoint> points);

  double length() const { return length_; }
  /// Stations of the points that the curve was made from [m].
  std::vector<double> knot_stations() const;
  /// Number of the last point at or before a station in [0, length).
  std::size_t knot_before(double s) const { return piece_index(s); }
  CurvePoint at(double s) const;
  CurveLocation locate(double x, double y) const;
  CurveLocation locate(double x, double y, double hint_s) const;

 private:
  struct Cubic {
    double a = 0.0, b = 0.0, c = 0.0, d = 0.0;  ///< a + b t + c t^2 + d t^3
    double value(double t) const { return a + t * (b + t * (c + t * d)); }
    double slope(double t) const { return b + t * (2.0 * c + 3.0 * d * t); }
    double bend(double t) const { return 2.0 * c + 6.0 * d * t; }
  };
  struct Piece {
    Cubic x, y;
    double width = 0.0;  ///< of the parameter
    double s = 0.0;      ///< station of its first knot
    double length = 0.0;
    int panels = 1;  ///< of the quadrature: more where the speed of the parameter varies much
  };
  static double arc_length(const Piece& piece, double t);
  static void measure(Piece& piece);
  static double parameter(const Piece& piece, double along);
  std::size_t piece_index(double s) const;
  CurvePoint point(const Piece& piece, double t) const;
  double knot_distance2(std::size_t i, double x, double y) const;
  CurveLocation refine(std::size_t knot, double x, double y) const;
  CurveLocation foot(const Piece& piece, double low, double high, double t, double x, double y) const;
  bool may_be_nearer(std::size_t i, double x, double y, double than) const;
  CurveLocation nearest_on(std::size_t i, double x, double y) const;

  std::vector<Piece> pieces_;
  std::vector<std::size_t> bucket_;  ///< piece at the start of the i-th equal share of the length
  double length_ = 0.0;
  double longest_piece_ = 0.0;
};

}  // namespace gripline
