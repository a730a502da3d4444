// Roads from tables of points: centre line with half widths, centre line with both edges, or the two edges alone.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "geometry/track.hpp"
#include "util/csv.hpp"

namespace gripline {

inline constexpr std::size_t fewest_points = 8;  ///< that make a road

struct ImportOptions {
  bool left_handed = false;  ///< the table's y axis points right (Carla): y changes sign
};

/// A road from a table with columns x_m,y_m,w_tr_right_m,w_tr_left_m[,grade_rad,bank_rad] (the TUM convention), or
/// x_center_m,y_center_m,x_inner_m,y_inner_m,x_outer_m,y_outer_m with corresponding points; which edge is left follows
/// from the geometry. The centre line is a periodic C2 spline through the points; a last point equal to the first is
/// dropped. Throws InputError with file and line: unknown columns, too few points, repeated points, an open line.
TrackShape shape_from_table(const CsvTable& table, const ImportOptions& options = {});

/// One edge of a road as measured: points in the direction of travel, and their heights if known (else empty).
struct EdgePoints {
  std::vector<PlanePoint> points;
  std::vector<double> heights;
  std::string remark = {};      ///< what was changed of the heights
  std::vector<int> lines = {};  ///< of the points in their file
  /// Columns x_m,y_m[,z_m]. A last row that repeats the first at another height shows how far heights drifted in the
  /// lap: that is evened out along the way, beyond 0.5 % of the length refused.
  static EdgePoints from_table(const CsvTable& table);
};

/// A road between two measured edges whose points need not correspond; which one is left follows from the geometry. The
/// centre line is where both edges are equally far, every `spacing` metres (0: half the mean width). Heights give grade
/// and bank. Throws GeometryError if the edges cross or do not run the same way round.
TrackShape shape_from_edges(const EdgePoints& inner, const EdgePoints& outer, double spacing = 0.0);

/// Grade by station of `centre` from heights [m] at stations [m] of another line beside it, through a periodic spline:
/// grade = atan(dz/ds), which closes in height.
StationTable grade_from_heights(const ClosedCurve& centre, const ClosedCurve& measured_along,
                                std::span<const double> stations, std::span<const double> heights);

/// Grade by station from heights at stations of the same line.
StationTable grade_from_heights(double length, std::span<const double> stations, std::span<const double> heights);

/// Removes the closing point, if it repeats the first (nearer to it than an eighth of both steps beside), and throws
/// GeometryError unless the line through the points is closed: the gap from the last to the first is at most five times
/// what nine tenths of the steps are, or three times the longest: a road with few points on its straights may begin
/// anywhere.
void drop_closing_point_and_check_closed(std::vector<PlanePoint>& points);

}  // namespace gripline
