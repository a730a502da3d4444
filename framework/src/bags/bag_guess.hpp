// A first map of a bag: topics by the types of their messages, others by names, then as for any table
// (measured/session/log_guess.hpp).
#pragma once

#include "bags/bag_file.hpp"
#include "measured/session/log_guess.hpp"

namespace gripline::bags {

/// Throws InputError when no topic looks like a motion or a command of a car.
measured::Guess guess_map(BagFile& bag);

}  // namespace gripline::bags
