/// \file
/// Values that repeat after a period: stations of a closed road, shares of a lap.
#pragma once

#include <cmath>

namespace gripline {

/// `value` moved by whole periods into [0, period), for a period above 0. 0 for a value or a period that is not a
/// number, for an infinite value, and for one so large that its place in the period is lost to rounding.
inline double wrap_periodic(double value, double period) {
  if (value >= 0.0 && value < period) return value;
  double wrapped = value - period * std::floor(value / period);
  if (wrapped < 0.0) wrapped += period;  // the quotient was rounded up to a whole number
  return wrapped >= 0.0 && wrapped < period ? wrapped : 0.0;
}

}  // namespace gripline
