// One step of a linear system: what a state and an input become after h.
#pragma once

#include <cstddef>

namespace gripline::diagnose {

/// For z' = A z + b with n states, of which nothing depends on the first two (x, y), the last three only fade and drive
/// the states 3 to 5, and an input b into these that is linear in time: z(h) = F z(0) + in0 b(0) + in1 b(h), h in
/// seconds. A and F are n x n, in0 and in1 are n x 3, all row-major and the caller's; n is 9 to 13 (states.hpp).
void transition(const double* A, std::size_t n, double h, double* F, double* in0, double* in1);

}  // namespace gripline::diagnose
