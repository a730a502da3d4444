// What noise of a sensor is measured by: differences of its readings that a smooth motion hardly touches.
#pragma once

#include <cstddef>
#include <span>

namespace gripline::measured {

/// What one of the readings counts for in their divided difference, in one over the unit of `at` to the power of its
/// order. `at`: as below.
double divided_weight(std::span<const double> at, std::size_t reading);

/// Divided difference of readings, one more of them than its order, over the standard deviation that white noise of one
/// gives it: a motion that is a polynomial of a lower order is not seen. `at`: when they were read, in any unit, no two
/// of them alike.
double scaled_difference(std::span<const double> at, std::span<const double> reading);

}  // namespace gripline::measured
