// What checks of units share: the median ratio of two channels, what it is where one has a wrong unit, and what
// commands cannot be.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {

/// The median size of what is not 0; 0 where all is.
inline double median_magnitude(std::vector<double> values) {
  for (double& v : values) v = std::abs(v);
  std::erase(values, 0.0);
  return median(std::move(values), 0.0);
}

/// Median of `top` / `bottom` over windows where both are large, of one another's motion: where one of them alone is, a
/// reading is wrong (a placeholder of -9999, a place of 0, 0). Each is large or small against its own median, so that
/// windows with a wrong reading have the share among those looked at that they have among all. NaN where there are less
/// than `fewest`; windows without one of the two do not count.
template <class Windows, class Top, class Bottom>
double median_ratio(const Windows& windows, Top top, Bottom bottom, std::size_t fewest = 1) {
  std::vector<double> tops, bottoms, sizes, ratios;
  for (const auto& w : windows)
    if (std::isfinite(top(w) + bottom(w))) tops.push_back(top(w)), bottoms.push_back(bottom(w));
  const double median_top = median_magnitude(tops), median_bottom = median_magnitude(bottoms);
  if (!(median_bottom > 0.0)) return not_a_number;
  for (std::size_t i = 0; i < tops.size(); ++i) {
    const double size = std::abs(bottoms[i]) / median_bottom;
    sizes.push_back(median_top > 0.0 ? std::min(size, std::abs(tops[i]) / median_top) : size);
  }
  const double enough = 0.5 * lower_quantile(sizes, 0.9, 0.0);
  for (std::size_t i = 0; i < tops.size(); ++i)
    if (sizes[i] >= enough && bottoms[i] != 0.0) ratios.push_back(tops[i] / bottoms[i]);
  return ratios.size() < fewest ? not_a_number : upper_median(ratios, not_a_number);
}

/// Whether two channels that show one motion agree but for slip, noise and scale: no other unit is so near.
inline bool is_about(double ratio, double expected = 1.0) { return ratio > 0.6 * expected && ratio < 1.6 * expected; }
/// Whether the upper of two rates is in degrees, where the ratio of them would be one: it is 57.
inline bool is_of_degrees(double ratio) { return ratio > 30.0 && ratio < 90.0; }
/// Whether the lower is.
inline bool is_over_degrees(double ratio) { return ratio > 1.0 / 90.0 && ratio < 1.0 / 30.0; }
/// Whether the rates have opposite signs, in whatever units.
inline bool has_other_sign(double ratio) { return ratio < -0.3 || is_over_degrees(-ratio); }

inline constexpr double most_steering = 1.6;  // [rad] no wheel turns further: beyond it the angle is in degrees
/// Whether an angle that is hardly exceeded is the handwheel's, by the car's limit [rad], 0 where that is not known. A car
/// steers beyond its limit by an error of calibration, never by half.
inline bool is_of_handwheel(double steered, double delta_max) { return delta_max > 0.0 && steered > 1.5 * delta_max; }
inline constexpr double often_steered = 0.97;  // of the rows have no larger angle than what is compared with it
inline constexpr double most_pedal = 1.5;      // [1] beyond it d is in per cent, or a pressure

/// A unit that was taken for the right one makes the speed that is read this many times that of the place. No wider:
/// the advice is followed, and what is left of the error may pass.
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
