// How numbers are written in messages and tables for people, and the one that stands where there is none.
#pragma once

#include <cstdio>
#include <limits>
#include <string>

namespace gripline {

/// Stands where a number is missing; compares false with everything.
inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// As printf writes it, cut at 300 characters: format("%.1f m of %d", 2.5, 3).
template <class... Values>
std::string format(const char* pattern, Values... values) {
  char text[300];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

/// With so many significant digits at most, as %g writes it.
inline std::string significant(double value, int digits = 3) { return format("%.*g", digits, value); }

}  // namespace gripline
