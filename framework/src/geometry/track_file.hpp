// Roads from JSON and CSV files (framework/doc/worlds.md).
#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <vector>

#include "config/errors.hpp"
#include "config/node.hpp"
#include "geometry/track.hpp"

namespace gripline {

/// Why a road in OpenDRIVE is refused, and what to do instead.
inline constexpr const char* not_opendrive =
    "is OpenDRIVE, which is not read; export its reference line as a CSV x_m,y_m,w_tr_right_m,w_tr_left_m";

/// Reads a road: the name of a .json or .csv file (relative to where it is written), or an object with exactly one of
///   "segments"   straights and arcs, turns to the left positive, with "half_width" and "origin"
///   "centre"     see shape_from_table
///   "edges"      see shape_from_edges
/// and "name", "start", "grade" or "height", "bank", "walls"; every key is explained in framework/doc/worlds.md.
/// Empty after an error, which has been added to `errors`.
std::optional<Track> read_track(const Node& node, Errors& errors);

/// A road from a .json or .csv file. Throws InputError.
Track load_track(const std::filesystem::path& file);

/// The tables of points that a road in JSON names ("centre", "edges"). Not checked for existence.
std::vector<std::filesystem::path> named_tables(const Node& road);

/// Writes x_m,y_m,w_tr_right_m,w_tr_left_m,grade_rad,bank_rad every `spacing` metres: what shape_from_table reads.
void write_track_csv(std::ostream& out, const Track& track, double spacing);

}  // namespace gripline
