// Guesses the columns that show how a car moves, their units and their signs.
#pragma once

#include "measured/session/guess_draft.hpp"

namespace gripline::measured {

/// Place, yaw, velocity and yaw rate, after the time. What no header and no name says of headings and speeds, the path
/// of the places does.
void guess_motion(GuessDraft& draft);

}  // namespace gripline::measured
