#include "support/allocation_counter.hpp"

#include "util/allocation_counter.hpp"

namespace gripline::rig {

std::atomic<long>& allocations = gripline::allocations;
const bool counts_allocations = gripline::counts_allocations;

}  // namespace gripline::rig
