// Makes a session of a logger's table and a map: rows in SI units, from the time of the first row on.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "measured/finding.hpp"
#include "measured/session/log_map.hpp"
#include "tables/delimited_table.hpp"

namespace gripline::measured {

struct SessionFile {
  Session session;
  std::vector<Finding> findings;
  bool has_throttle = false;      // else vx is taken from the log
  bool derived_velocity = false;  // vx, vy from differences of the place
  bool derived_yaw = false;       // the course over ground
  double row_step = 0;            // median [s]
};

/// Reads a log through a map. Readings that are missing, or held from the row before where the map says so, are NaN;
/// yaw is unwrapped; what the log lacks is derived from what it has (speed and course from places) or left out. Frames
/// are those that the map states; what is derived is of the point that the places show, in axes that are not turned, a
/// vx beside a vy that is read in those of vy's unit.
/// Rows of one time stamp become one, and those before the first commands are left out; nothing is smoothed, moved or
/// interpolated. Throws InputError: a missing column, one without numbers, a wrong unit, time that runs backward or
/// steps by more than an hour, fewer than 20 rows, no steering.
SessionFile read_session(const std::filesystem::path& log, const LogMap& map);
SessionFile read_session(DelimitedTable table, const LogMap& map);

}  // namespace gripline::measured
