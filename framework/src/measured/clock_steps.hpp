// Steps of a log's times: whether they are seconds, and what no logger writes.
#pragma once

#include <span>

namespace gripline::measured {

/// Steps of one second are those of a slow logger, or the milliseconds of a quick one.
inline constexpr double least_count = 5.0;  // a step below it may be one in seconds
inline bool may_be_seconds_or_milliseconds(double step) { return step > 0.9 && step < least_count; }

inline constexpr double longest_step = 3600.0;  // [s] of a clock that was not set
inline constexpr double shortest_step = 1e-4;   // [s] that a logger writes; less is between rows of a bus in a burst

/// Mean of the steps [s] of a log whose rows come in bursts: their number shows how often they come. 0 of none.
inline double mean_step(std::span<const double> steps) {
  double sum = 0.0, count = 0.0;
  for (const double step : steps)
    if (step <= longest_step) sum += step, count += 1.0;
  return count > 0.0 ? sum / count : 0.0;
}

}  // namespace gripline::measured
