// Whether a session's channels are consistent with each other: what may still be right is warned of, not refused.
#pragma once

#include <functional>
#include <vector>

#include "measured/finding.hpp"
#include "measured/session/session_file.hpp"

namespace gripline::measured {

/// Channels that seem inconsistent with the others: steering that the car does not follow, a lateral speed against the
/// place, a speed significantly other than that of the place, a yaw that is the course though vy is not 0.
/// `place_is_late`: by how much against the speeds [s], asked only where it matters, since a place that comes late moves
/// sideways by where the car was heading then; without it, or where that is 0, the place counts as on time.
std::vector<Finding> consistency_warnings(const SessionFile& file,
                                          const std::function<double(const SessionFile&)>& place_is_late = {});

}  // namespace gripline::measured
