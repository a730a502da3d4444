// How good a session is: rate, gaps, held and jumping channels, timing slips, noise and its colour, delays.
#pragma once

#include <vector>

#include "measured/finding.hpp"
#include "measured/session/session_file.hpp"

namespace gripline::measured {

/// Commands that stay where they are: what they do to the car cannot be learned from this log.
std::vector<Finding> constant_commands(const Session& session);

/// All of it as lines of a table, after what reading found. What is typical of a channel, and its noise, are of the
/// rows in which the car moves (moving_rows).
std::vector<Finding> health_of(const SessionFile& file);

}  // namespace gripline::measured
