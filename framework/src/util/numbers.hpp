// How numbers are written in messages and tables for people, and the one that stands where there is none.
#pragma once

#include <limits>
#include <string>

namespace gripline {

/// Stands where a number is missing; compares false with everything.
inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Text by a printf pattern, of any length and always in the C locale: format("%.1f m of %d", 2.5, 3). A program that
/// hosts this one, such as Python, may have set a locale with decimal commas.
[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...);

/// With so many significant digits at most, as %g writes it.
inline std::string significant(double value, int digits = 3) { return format("%.*g", digits, value); }

}  // namespace gripline
