// Guesses the columns of a car's commands, d and delta, and what is to be done with their numbers.
#pragma once

#include "measured/session/guess_draft.hpp"

namespace gripline::measured {

/// Pedals as shares of full throttle and full brake in one channel, and the angle of the front wheels with its sign,
/// which the yaw rate tells, or without one the heading: after guess_motion.
void guess_commands(GuessDraft& draft);

}  // namespace gripline::measured
