// A closed road as a table: points along its centre line, with half widths, heights and slopes beside each.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/track.hpp"

namespace gripline {

/// Points along a closed centre line in the direction of travel, the first not repeated at the end.
struct RoadTable {
  std::string name;
  std::vector<PlanePoint> points;   ///< [m]
  std::vector<double> right, left;  ///< half widths [m]
  std::vector<double> height;       ///< [m]; empty where the file has none
  std::vector<double> grade, bank;  ///< [rad] as in TrackShape; empty where the file has none
  std::optional<Pose> start;        ///< of races, if elsewhere than at the first point
  bool bridges = false;
  bool walls = false;       ///< the road has walls, which are not in the table
  bool edges_known = true;  ///< false: a trace between edges that nobody measured, with a width from elsewhere

  std::size_t size() const { return points.size(); }
  /// Length of the chords, the closing one included [m].
  double length() const;
  /// What stands beside the points: right, left, height, grade and bank, but for those that are empty.
  std::vector<std::vector<double>*> columns();
};

/// All lengths times `factor`; slopes stay.
void scale(RoadTable& road, double factor);
/// The same road driven the other way, from the same first point.
void reverse(RoadTable& road);

inline constexpr double steepest_edge = 0.5;  ///< largest sound change of a half width per metre of road

/// Where a half width changes faster than steepest_edge between neighbouring points.
struct WidthStep {
  PlanePoint at;
  double from = 0.0, to = 0.0;  ///< [m]
  bool right = false;           ///< which edge
};
std::vector<WidthStep> width_steps(const RoadTable& road);

/// Throws GeometryError (Track).
Track to_track(const RoadTable& road);

/// x_m,y_m,w_tr_right_m,w_tr_left_m,grade_rad,bank_rad, and for bridges and a start a JSON file that names the CSV:
/// what load_track reads. `out` ends in .csv or .json; the CSV lies beside a .json. Throws GeometryError where a CSV
/// alone cannot say that crossings are bridges.
void write_road(const std::filesystem::path& out, const Track& track, const RoadTable& road);

/// Where write_road puts the points of a road whose `out` ends in .json.
std::filesystem::path points_beside(const std::filesystem::path& out);

}  // namespace gripline
