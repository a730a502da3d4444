// Whether the clock of a session's places slips once in a period.
#pragma once

#include <optional>

#include "measured/session/session.hpp"

namespace gripline::measured {

/// A position that is written too early or too late once in a period, and catches up in between.
struct TimingSlip {
  double period = 0;  // [s]
  double phase = 0;   // of the log's time [s]
  double travel = 0;  // time of travel lost there; negative: the position falls back [s]
  double score = 0;   // in standard deviations of its mean
};
/// The strongest slip with a period of 0.1 to 10 s; empty below 8 standard deviations or 1 ms, or where x or vx was
/// not read. `row_step`: median time between rows [s].
std::optional<TimingSlip> timing_slip(const Session& session, double row_step);

}  // namespace gripline::measured
