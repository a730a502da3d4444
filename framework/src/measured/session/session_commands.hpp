// The commands of a session: of its readings by row, and what they do between rows.
#pragma once

#include <span>
#include <vector>

#include "measured/finding.hpp"
#include "measured/session/log_map.hpp"
#include "measured/session/session.hpp"

namespace gripline::measured {

/// Fills the commands of a session whose rows have their times. `d` (empty where the log has no throttle: the speed is
/// then prescribed) and `delta` [rad]: by row, NaN where none was read; the last one is held. Findings: rows without a
/// command, and a throttle or a steering that changes more often than the map says that the logger reads it.
void fill_commands(Session& session, std::span<const double> d, std::span<const double> delta, const LogMap& map,
                   std::vector<Finding>& findings);

}  // namespace gripline::measured
