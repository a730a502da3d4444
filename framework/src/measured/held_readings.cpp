#include "measured/held_readings.hpp"

#include <cmath>
#include <limits>

#include "util/statistics.hpp"

namespace gripline::measured {

std::size_t drop_held(std::span<const double> t, std::vector<double>& values) {
  constexpr std::size_t few = 3, many = 101;  // times between new values that the usual one is the median of
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> between;
  double last = none, usual = 0.0, changed = 0.0, next = 0.0;
  std::size_t dropped = 0, changes = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;  // an empty cell is no reading
    const bool same = values[i] == last;
    last = values[i];
    if (!same) {
      if (changes > 0 && between.size() < many)
        between.push_back(t[i] - changed);
      else if (changes > 0)
        between[changes % many] = t[i] - changed;
      ++changes;
      usual = between.size() < few ? 0.0 : median(between);
      changed = t[i];
      next = t[i] + 2.0 * usual;
    } else if (usual > 0.0 && t[i] >= next - 1e-9) {
      next = t[i] + usual;
    } else {
      values[i] = none;
      ++dropped;
    }
  }
  return dropped;
}

}  // namespace gripline::measured
