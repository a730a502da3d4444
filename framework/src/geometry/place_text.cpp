#include "geometry/place_text.hpp"

#include <algorithm>
#include <cmath>

#include "util/numbers.hpp"

namespace gripline {

std::string place_text(double x, double y, int digits) {
  constexpr double rounding = 1e-6;
  const double least = rounding * std::max({1.0, std::abs(x), std::abs(y)});
  const auto text = [&](double value) { return significant(std::abs(value) < least ? 0.0 : value, digits); };
  return "(" + text(x) + ", " + text(y) + ")";
}

}  // namespace gripline
