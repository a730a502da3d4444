// Roads as users write them.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>

#include "config/errors.hpp"
#include "config/node.hpp"
#include "geometry/track.hpp"

namespace gripline {

/// Reads a road: the name of a .json or .csv file (relative to where it is written), or an object.
///
///   {"origin": {"x", "y", "yaw"}, "segments": [{"line": 1.7}, {"arc": {"radius": 0.2, "turn": "180 deg"}}, ...],
///    "half_width": 0.185 | {"left", "right"} | [{"s", "left", "right"}, ...]}           straights and arcs; turns left
///    > 0
///   {"centre": "road.csv", "left_handed": false}                                        see shape_from_table
///   {"edges": {"inner": "a.csv", "outer": "b.csv", "spacing": 2}}                       see shape_from_edges
///
/// Each may add "name", "start" (a pose), "grade": [{"s", "grade"}, ...] or "height": [{"s", "z"}, ...], "bank": [{"s",
/// "bank"}, ...], and "walls": {"left": 3, "right": 3} [m beyond the edges] or [{"side": "left", "from_s", "to_s",
/// "distance"}, ...].
/// Empty after an error, which has been added to `errors`.
std::optional<Track> read_track(const Node& node, Errors& errors);

/// A road from a .json or .csv file. Throws InputError.
Track load_track(const std::filesystem::path& file);

/// Writes x_m,y_m,w_tr_right_m,w_tr_left_m,grade_rad,bank_rad every `spacing` metres: what shape_from_table reads.
void write_track_csv(std::ostream& out, const Track& track, double spacing);

}  // namespace gripline
