// Whether the steps of a log's times are seconds.
#pragma once

namespace gripline::measured {

/// Steps of one second are those of a slow logger, or the milliseconds of a quick one.
inline constexpr double least_count = 5.0;  // a step below it may be one in seconds
inline bool may_be_seconds_or_milliseconds(double step) { return step > 0.9 && step < least_count; }

}  // namespace gripline::measured
