#include "measured/session/log_clock.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gripline::measured {

std::vector<double> times_since(double begin, std::vector<double> times, double latest) {
  if (begin == 0.0) return times;
  const double largest = std::max(std::abs(begin), std::abs(latest));
  const double apart = std::nextafter(largest, std::numeric_limits<double>::infinity()) - largest;
  // The differences of two rounded numbers are off by up to `apart`.
  const double per_second = std::pow(10.0, std::floor(-std::log10(2.0 * apart)));
  std::vector<double> rounded = times;
  for (double& t : rounded) t = std::round((t - begin) * per_second) / per_second;
  for (std::size_t i = 1; i < times.size(); ++i)
    if (rounded[i] == rounded[i - 1] && times[i] != times[i - 1]) {  // messages of a bus, in a burst
      for (double& t : times) t -= begin;
      return times;
    }
  return rounded;
}

}  // namespace gripline::measured
