// Guesses the columns of a car's commands, d and delta, and what is to be done with their numbers.
#pragma once

#include "measured/session/guess_draft.hpp"

namespace gripline::measured {

/// Pedals as shares of full throttle and full brake in one channel, and the angle of the front wheels with its sign,
/// found from the yaw rate, or without one from the heading: after guess_motion.
void guess_commands(GuessDraft& draft);

}  // namespace gripline::measured
