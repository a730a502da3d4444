// Whether a session's channels are consistent with each other: what may still be right is warned of, not refused.
#pragma once

#include <vector>

#include "measured/finding.hpp"
#include "measured/session/session_file.hpp"

namespace gripline::measured {

/// Channels that seem inconsistent with the others: steering that the car does not follow, a lateral speed against the
/// place, a speed significantly other than that of the place, a yaw that is the course though vy is not 0.
std::vector<Finding> consistency_warnings(const SessionFile& file);

}  // namespace gripline::measured
