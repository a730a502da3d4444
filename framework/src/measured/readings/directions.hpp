// What many angles show of a direction, whatever turns they are counted in.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

namespace gripline::measured {

/// Mean of unit vectors at these angles [rad]: its length says how far the angles agree, from 0 to 1, its argument is
/// their circular mean. 0 of none.
inline std::complex<double> mean_direction(const std::vector<double>& angles) {
  std::complex<double> sum;
  for (const double angle : angles) sum += std::polar(1.0, angle);
  return sum / std::max(1.0, static_cast<double>(angles.size()));
}

/// Whether angles agree but for an offset that all of them have: slip, noise and places that are late leave more.
inline bool are_alike(const std::complex<double>& mean) { return std::abs(mean) > 0.9; }
/// Whether angles between what should point one way are those of slip and noise, about 0.
inline bool are_about_zero(const std::complex<double>& mean) {
  constexpr double least = 0.7, most = 0.6;  // of length; [rad]
  return std::abs(mean) > least && std::abs(std::arg(mean)) < most;
}
/// Whether sums of a heading and the course of its path, which are `are_alike`, are those of x and y by turns: a mirror
/// on the diagonal. (So is a compass's clockwise angle from +y.)
inline bool is_about_a_quarter(const std::complex<double>& mean) {
  return std::abs(std::arg(mean) - std::numbers::pi / 2) < 0.3;
}

}  // namespace gripline::measured
