// The allocations of a test program (util/allocation_counter.hpp). Include in one source file of it.
#pragma once

#include "util/allocation_counter.hpp"

namespace gripline::rig {

using gripline::allocations;
using gripline::counts_allocations;

}  // namespace gripline::rig
