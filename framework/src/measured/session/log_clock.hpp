// Times of a log counted from its first row. Clocks of loggers count from their start, from midnight or from 1970: near
// 1.7e9 s neighbouring numbers are 2.4e-7 s apart, and nothing that compares times closely would work.
#pragma once

#include <vector>

namespace gripline::measured {

/// What lies between `begin` and each of `times` [s], of a clock that shows up to `latest`: to the digits that numbers
/// so large can hold, so that 0.05 s stay 0.05 s, unless rows would become one. NaN stays NaN.
std::vector<double> times_since(double begin, std::vector<double> times, double latest);

}  // namespace gripline::measured
