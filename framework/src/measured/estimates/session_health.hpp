// How good a session is: rate, gaps, held and jumping channels, timing slips, noise and its colour, delays.
#pragma once

#include <optional>
#include <vector>

#include "measured/finding.hpp"
#include "measured/session/session_file.hpp"

namespace gripline::measured {

/// A position that is written too early or too late once in a period, and catches up in between.
struct TimingSlip {
  double period = 0;  // [s]
  double phase = 0;   // of the log's time [s]
  double travel = 0;  // time of travel lost there; negative: the position falls back [s]
  double score = 0;   // in standard deviations of its mean
};
/// The strongest slip with a period of 0.1 to 10 s; nothing below 8 standard deviations or 1 ms, or where x or vx was
/// not read. `row_step`: usual time between rows [s].
std::optional<TimingSlip> timing_slip(const Session& session, double row_step);

/// Commands that stay where they are: what they do to the car cannot be learned from this log.
std::vector<Finding> constant_commands(const Session& session);

/// All of it as lines of a table, after what reading found. What is usual of a channel, and its noise, are of the rows in
/// which the car moves (moving_rows).
std::vector<Finding> health_of(const SessionFile& file);

}  // namespace gripline::measured
