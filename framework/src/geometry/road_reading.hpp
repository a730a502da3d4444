// Roads in formats of other tools, read as tables of points.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "geometry/road_table.hpp"

namespace gripline {

struct RoadReading {
  double width = 0.0;        ///< [m] whole width of a trace that has none; 0: none is known
  double largest_gap = 0.0;  ///< [m] an open line whose ends are at most so far apart is closed; 0: as load_track
};

/// Reads one file, or the files of the left and the right edge:
///   CSV with widths      x_m,y_m,w_tr_right_m,w_tr_left_m[,grade_rad,bank_rad] or other names (road_columns.hpp)
///   all three lines      x_center_m,y_center_m,x_inner_m,y_inner_m,x_outer_m,y_outer_m
///   trace, CSV           x_m,y_m[,z_m] or lat,lon[,ele], degrees and metres, or other names: with `width`
///   trace, GPX           track points, else route points: with `width`
///   edges, two CSVs      x_m,y_m[,z_m] or lat,lon[,ele], or other names
///   .json                any road that load_track reads
/// Places on the earth are projected to the plane that touches the WGS 84 ellipsoid at their middle: x east, y north. A
/// trace, a TUM CSV and edges are repaired (trace_repair.hpp). `remarks` gets a line for each change. Throws InputError
/// and GeometryError.
RoadTable read_road(std::span<const std::filesystem::path> files, const RoadReading& reading,
                    std::vector<std::string>& remarks);

}  // namespace gripline
