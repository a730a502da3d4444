// Channels that a recorder rounded: to which step, and what a rounded command may have been.
#pragma once

#include "measured/log/log.hpp"

namespace gripline::measured {

/// The step of which the differences of all values are multiples, the least of them; 0 where there is none and of fewer
/// than eight values that differ (a switch). NaNs do not count.
double step_of(std::vector<double> values);

/// Steps of throttle [1] and steering [rad], 0: none. Commands that were not recorded do not count.
Commands command_steps(std::span<const Log> stretches);
/// Steps of the readings; 0: none. Yaw may have been rounded before or after it was wrapped.
Channels reading_steps(std::span<const Log> stretches);

/// Standard deviation of what rounding to a step takes off or adds where it is evenly distributed.
double rounding_noise(double step);

/// Replaces rounded commands by their expected values and fills Log::rounding_error. Nothing changes of one whose step
/// is 0.
///
/// A command moves from sample to sample by independent amounts of a heavy-tailed distribution (Student's t with three
/// degrees of freedom: drivers hold still and jump), and lies within half a step of what was written. The scale
/// of its moves is what makes the written ones likeliest. Where it moves by more than a step the errors are white and
/// of step^2 / 12; where it rests they last.
void unround_commands(Log& log, const Commands& steps);

}  // namespace gripline::measured
