#include "measured/readings/bridged_readings.hpp"

#include <cmath>

#include "measured/channels.hpp"

namespace gripline::measured {

std::vector<double> bridged_readings(std::span<const double> t, std::vector<double> reading, double longest_gap) {
  for (std::size_t c = 0; c < channels; ++c) {
    std::size_t last = t.size();
    for (std::size_t i = 0; i < t.size(); ++i) {
      const double here = reading[i * channels + c];
      if (std::isnan(here)) continue;
      const bool near = last < i && !is_longer(t[i] - t[last], longest_gap);
      for (std::size_t j = last + 1; near && j < i; ++j) {
        const double before = reading[last * channels + c];
        reading[j * channels + c] = before + (here - before) * (t[j] - t[last]) / (t[i] - t[last]);
      }
      last = i;
    }
  }
  return reading;
}

}  // namespace gripline::measured
