// Frictions that speeds are planned for, and what is driven at less.
#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace gripline::planning {

/// Friction coefficients from `lo` to `hi`, equally spaced by at most `step`. Throws std::invalid_argument for hi < lo.
inline std::vector<double> friction_grid(double lo, double hi, double step) {
  if (hi < lo) throw std::invalid_argument("mu_hi is below mu_lo");
  std::vector<double> mus{lo};
  const int intervals = static_cast<int>(std::ceil((hi - lo) / step - 1e-9));
  for (int i = 1; i <= intervals; ++i) mus.push_back(std::lerp(lo, hi, static_cast<double>(i) / intervals));
  return mus;
}

/// Less than any road has. A belief in less must not stop the car, which then would learn nothing more.
inline constexpr double least_friction = 0.01;

/// The share of speeds planned for the friction `planned` that is driven at friction `mu`: 1, and where mu is less the
/// root of their ratio, which tyres allow.
inline double speed_share(double mu, double planned) {
  return mu < planned ? std::sqrt(std::max(mu, least_friction) / planned) : 1.0;
}

}  // namespace gripline::planning
