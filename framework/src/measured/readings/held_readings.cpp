#include "measured/readings/held_readings.hpp"

#include <cmath>

#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {

std::size_t drop_held(std::span<const double> t, std::vector<double>& values) {
  constexpr std::size_t few = 3, many = 101;  // times between new values that are counted
  std::vector<double> between;
  double last = not_a_number, interval = 0.0, changed = 0.0, next = 0.0;
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
      interval = between.size() < few ? 0.0 : median(between);
      changed = t[i];
      next = t[i] + 2.0 * interval;
    } else if (interval > 0.0 && t[i] >= next - 1e-9) {
      next = t[i] + interval;
    } else {
      values[i] = not_a_number;
      ++dropped;
    }
  }
  return dropped;
}

double rows_between_new(std::span<const double> t, std::span<const double> values) {
  constexpr double standing = 2.0;  // [s]
  constexpr double few = 20.0;
  double count = 0.0, sum = 0.0, squares = 0.0, single = 0.0;
  std::size_t last = values.size(), rows = 0;  // where the last new value stands, rows since then
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    ++rows;
    if (last < i && values[i] == values[last]) continue;
    if (last < i && t[i] - t[last] <= standing) {
      const auto n = static_cast<double>(rows);
      count += 1.0, sum += n, squares += n * n, single += rows == 1 ? 1.0 : 0.0;
    }
    last = i;
    rows = 0;
  }
  if (count < few) return 1.0;
  const double mean = sum / count, variance = squares / count - mean * mean;
  if (mean < 1.5) return 1.0;
  // New values that come by chance wait a geometric time, whose variance is mean (mean - 1).
  const bool regular = mean <= 2.0 ? variance < 0.5 * mean * (mean - 1.0) : single < 0.2 * count;
  return regular ? mean : 1.0;
}

}  // namespace gripline::measured
