// Roads in formats of other tools: read as rows of points, repaired, and turned into a Track.
#pragma once

#include <filesystem>
#include <span>
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
  bool bridges = false;
  bool edges_known = true;  ///< false: a trace between edges that nobody measured, with a width from elsewhere

  std::size_t size() const { return points.size(); }
  /// Length of the chords, the closing one included [m].
  double length() const;
};

struct RoadReading {
  double width = 0.0;        ///< [m] whole width of a trace that has none; 0: none is known
  double largest_gap = 0.0;  ///< [m] an open line whose ends are at most so far apart is closed; 0: as load_track
};

/// Reads one file, or the files of the left and the right edge:
///   TUM CSV              x_m,y_m,w_tr_right_m,w_tr_left_m[,grade_rad,bank_rad]
///   all three lines      x_center_m,y_center_m,x_inner_m,y_inner_m,x_outer_m,y_outer_m
///   trace, CSV           x_m,y_m[,z_m] or lat,lon[,ele], degrees and metres: with `width`
///   trace, GPX           track points, else route points: with `width`
///   edges, two CSVs      x_m,y_m[,z_m] or lat,lon[,ele]
///   .json                any road that load_track reads
/// Places on the earth are projected to the plane that touches the WGS 84 ellipsoid at their middle: x east, y north. A
/// trace or a TUM CSV that continues beyond its start is cut where it comes back to it. `remarks` gets a line for each
/// change. Throws InputError and GeometryError.
RoadTable read_road(std::span<const std::filesystem::path> files, const RoadReading& reading,
                    std::vector<std::string>& remarks);

/// All lengths times `factor`; slopes stay.
void scale(RoadTable& road, double factor);
/// The same road driven the other way, from the same first point.
void reverse(RoadTable& road);

struct Smoothed {
  double moved = 0.0;   ///< largest distance of the road's points from the new centre line [m]
  double raised = 0.0;  ///< largest change of a height [m]
  double wanted = 0.0;  ///< least tolerance that would not keep the line from being the smoothest [m]
};
/// The smoothest line within `tolerance` [m] of the road's points: minimises the squared second differences plus
/// (move / half width^2)^2, so that only waves shorter than about three widths are removed. Points nearer to each other
/// than a hundredth of the width count as one. The edges stay where they are; a trace keeps its width. Half widths then
/// change by at most 1:2 along the road: at a step it is narrowed on the wide side. Heights are smoothed over ten half
/// widths. Throws GeometryError without widths.
Smoothed smooth(RoadTable& road, double tolerance);

/// The tolerance with which smooth() would make a sound road of one that is none [m]; 0: no tolerance would.
double helpful_tolerance(const RoadTable& road);

/// Where a half width changes by more than 1:2 between neighbouring points.
struct WidthStep {
  PlanePoint at;
  double from = 0.0, to = 0.0;  ///< [m]
  bool right = false;           ///< which edge
};
std::vector<WidthStep> width_steps(const RoadTable& road);

/// Throws GeometryError (Track).
Track to_track(const RoadTable& road);

/// x_m,y_m,w_tr_right_m,w_tr_left_m,grade_rad,bank_rad, and for bridges a JSON file that names the CSV: what load_track
/// reads. `out` ends in .csv or .json; the CSV lies beside a .json. Throws GeometryError where a CSV alone cannot say
/// that crossings are bridges.
void write_road(const std::filesystem::path& out, const Track& track, const RoadTable& road);

/// Where write_road puts the points of a road whose `out` ends in .json.
std::filesystem::path points_beside(const std::filesystem::path& out);

}  // namespace gripline
