// What checks of units share: the usual ratio of two channels, and which wrong unit makes a speed so many times another.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {

/// Median of `top` / `bottom` over windows where `bottom` is at least half its 90 % quantile. NaN where there are less
/// than `fewest`; windows without one of the two do not count.
template <class Windows, class Top, class Bottom>
double usual_ratio(const Windows& windows, Top top, Bottom bottom, std::size_t fewest = 1) {
  std::vector<double> sizes, ratios;
  for (const auto& w : windows)
    if (std::isfinite(top(w) + bottom(w))) sizes.push_back(std::abs(bottom(w)));
  const double enough = 0.5 * lower_quantile(sizes, 0.9, 0.0);
  for (const auto& w : windows)
    if (std::isfinite(top(w) + bottom(w)) && std::abs(bottom(w)) >= enough && bottom(w) != 0.0)
      ratios.push_back(top(w) / bottom(w));
  return ratios.size() < fewest ? not_a_number : upper_median(ratios, not_a_number);
}

/// A unit that was taken for the right one makes the speed that is read this many times that of the place. No wider: the
/// advice is followed, and what is left of the error may pass.
struct WrongUnit {
  double low, high;
  bool of_place;     // else of the speed
  const char* name;  // in messages
  const char* unit;  // in maps
};
inline constexpr std::array<WrongUnit, 8> wrong_units = {{{3.45, 3.8, false, "km/h", "km/h"},
                                                          {3.1, 3.42, false, "ft/s", "ft/s"},
                                                          {2.1, 2.4, false, "mph", "mph"},
                                                          {1.85, 2.05, false, "knots", "kn"},
                                                          {7e-4, 1.4e-3, true, "millimetres", "mm"},
                                                          {7e-3, 1.4e-2, true, "centimetres", "cm"},
                                                          {700, 1400, false, "mm/s", "mm/s"},
                                                          {70, 140, false, "cm/s", "cm/s"}}};

}  // namespace gripline::measured
