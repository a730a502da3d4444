// Friction schedules from JSON (framework/doc/worlds.md).
#pragma once

#include "config/errors.hpp"
#include "config/node.hpp"
#include "world/friction.hpp"

namespace gripline {

/// Reads a schedule: a list of points [{"t": 0, "factor": 1}, ...], the name of a .json file, or an object with any of
///   "points": [{"t", "factor"}, ...]                       linear between; the first and last values hold
///   "per_step": {"start_step", "divide", "end_step"}       f -= f / divide in steps start_step .. end_step
///   "patches": [{"from_s", "to_s", "factor", "from_t"}]    multiply between two stations, from time from_t (0) on
///   "shift_per_seed": "0.8 s"                              seed k sees all times later by (k - 1) times this
/// After an error, which has been added to `errors`, the value is fresh friction. Stations are checked where the track
/// is known: check_friction.
FrictionSpec read_friction(const Node& node, Errors& errors);

}  // namespace gripline
