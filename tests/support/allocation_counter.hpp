// How often a test's program has allocated (util/allocation_counter.hpp): a program that uses this counts.
#pragma once

#include <atomic>

namespace gripline::rig {

extern std::atomic<long>& allocations;
extern const bool counts_allocations;  // false where a sanitizer owns malloc

}  // namespace gripline::rig
