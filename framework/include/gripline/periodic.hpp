/// \file
/// Values that repeat after a period: stations of a closed road, shares of a lap.
#pragma once

#include <cmath>

namespace gripline {

/// `value` moved by whole periods into [0, period); 0 for a value that is not finite.
inline double wrap_periodic(double value, double period) {
  if (value >= 0.0 && value < period) return value;
  const double wrapped = value - period * std::floor(value / period);
  return wrapped < period ? wrapped : 0.0;
}

}  // namespace gripline
