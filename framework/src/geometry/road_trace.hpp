// Lines as they are measured: columns of a CSV, GPX files, places on the earth.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/plane.hpp"

namespace gripline {

/// Points as they were driven or surveyed, not yet closed. Heights and widths are empty where the file has none.
struct RoadTrace {
  std::vector<PlanePoint> points;   ///< [m], or with `on_earth` longitude and latitude [rad]
  std::vector<double> height;       ///< [m]
  std::vector<double> right, left;  ///< [m]
  std::vector<double> grade, bank;  ///< [rad]
  std::vector<int> line;            ///< of each point in its file, 0: unknown; empty: not from a file
  bool on_earth = false;
  std::vector<std::string> remarks;  ///< how the file is read, what of it is left out or made up, a line each
  std::string instead_of_widths;     ///< where it has none, which columns may be some, for a message; may be empty
};

/// A table of places and what RoadTrace has besides, by the names of its columns (road_columns.hpp). Throws InputError
/// with file and line.
RoadTrace read_csv_trace(const std::filesystem::path& file);
/// Track points of a GPX file, else its route points. Where a tenth of the points or less have no height, it is
/// interpolated; where more have none, heights are left out. Throws InputError, also where a height is not a number.
RoadTrace read_gpx_trace(const std::filesystem::path& file);

/// Where places on the earth are in the plane that touches the WGS 84 ellipsoid at `origin` (longitude, latitude).
PlanePoint on_tangent_plane(const PlanePoint& place, const PlanePoint& origin);
/// The middle of all places, for on_tangent_plane().
PlanePoint middle_of(const std::vector<PlanePoint>& places);

}  // namespace gripline
