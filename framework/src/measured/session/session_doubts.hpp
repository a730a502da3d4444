// Whether a session's channels fit each other: what hardly does, but may, is said and not refused.
#pragma once

#include <vector>

#include "measured/finding.hpp"
#include "measured/session/session_file.hpp"

namespace gripline::measured {

/// Channels that hardly fit the others, but may: steering that the car does not follow, a lateral speed against the
/// place, a speed that is surely another than that of the place, a yaw that is the course though vy is not 0.
std::vector<Finding> doubts_about(const SessionFile& file);

}  // namespace gripline::measured
