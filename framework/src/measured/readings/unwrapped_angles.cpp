#include "measured/readings/unwrapped_angles.hpp"

#include <cmath>
#include <numbers>

#include "util/numbers.hpp"

namespace gripline::measured {

std::size_t unwrap_angles(std::span<double> values, std::size_t first, std::size_t stride) {
  constexpr double turn = 2.0 * std::numbers::pi;
  double last = not_a_number, turns = 0.0;
  std::size_t changes = 0;
  for (std::size_t i = first; i < values.size(); i += stride) {
    double& angle = values[i];
    if (std::isnan(angle)) continue;
    const double needed = std::isnan(last) ? 0.0 : std::round((last - angle) / turn);
    changes += needed != turns ? 1 : 0;
    turns = needed;
    angle += turns * turn;
    last = angle;
  }
  return changes;
}

}  // namespace gripline::measured
