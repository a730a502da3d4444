// Which starts of logs are fitted, which are judged, and which are enough for searching.
#pragma once

#include <vector>

#include "calibrate/fit/prediction_errors.hpp"

namespace gripline::calibrate {

/// Stretches of a log that no fit sees: the last `length` of every `every` [s].
struct HeldOutTimes {
  double every = 60, length = 15;
  bool holds(double since_begin) const;
};

/// Starts of a log that are fitted (no horizon reaches into a held-out stretch), or that are judged (wholly inside
/// one).
FitLog part_of(const FitLog& all, const HeldOutTimes& times, bool judged);

/// The starts of one stretch of five seconds in every so many: the observer need not look at the others.
std::vector<FitLog> thinned(const std::vector<FitLog>& logs, std::size_t every);

}  // namespace gripline::calibrate
