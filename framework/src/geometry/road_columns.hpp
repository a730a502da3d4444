// What columns of a road's table are called, and the table read by such names.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gripline {

/// The rows of a road's table. What is named optional is empty where the table has none.
struct RoadColumns {
  bool on_earth = false;
  std::vector<double> x, y;          ///< [m]; with `on_earth` longitude and latitude [deg]
  std::vector<double> height;        ///< [m], optional
  std::vector<double> right, left;   ///< half widths [m], optional
  std::vector<double> grade, bank;   ///< [rad], optional
  std::vector<int> line;             ///< of each row in the file, from 1
  std::vector<std::string> remarks;  ///< what is read as what where the names are not gripline's, what is left out
  std::string instead_of_widths;     ///< which other columns may be widths, for a message; empty: none, or it has some
};

/// Reads a table in text (tables/delimited_table.hpp: any separator, decimal commas) by the names of its columns, in any
/// case, with units at their ends, in brackets or in a row of their own (x_m, X (ft)):
///   places       x and y, east and north, easting and northing, pose.position.x and .y: metres without a unit;
///                else lat and lon, latitude and longitude: degrees without a unit
///   heights      z, ele, elevation, alt, altitude: metres without a unit
///   half widths  right and left, w_right, width_right, w_tr_right and their like: metres without a unit;
///                else width, track_width, road_width, the whole one
///   slopes       grade, bank: only with their unit, rad, beside widths deg and % as well
/// Places and half widths are pairs of names (px,py and not px,northing) in one unit; of several the best is read. Other
/// columns are left out, without widths also heights, widths and slopes with another unit. Throws InputError with file
/// and line: no places, one half width alone, two units in a pair, lengths without a unit beside places in another than
/// m or in a row of units beside another, a unit of another kind, a cell without a number, and beside widths a slip in
/// the name of a slope.
RoadColumns read_road_columns(const std::filesystem::path& file);

}  // namespace gripline
