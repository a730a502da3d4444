// How numbers are written in messages and tables for people, and read from words; the one that stands where there is
// none.
#pragma once

#include <charconv>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace gripline {

/// Stands where a number is missing; compares false with everything.
inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Text by a printf pattern, of any length and always in the C locale: format("%.1f m of %d", 2.5, 3). A program that
/// hosts this one, such as Python, may have set a locale with decimal commas.
[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...);

/// With so many significant digits at most, as %g writes it.
inline std::string significant(double value, int digits = 3) { return format("%.*g", digits, value); }

/// A value with no more than so many significant digits; 0 and what is not finite as it is.
double rounded(double value, int digits);

/// The number that a whole text is, as C writes it, without a sign '+' or blanks; "inf" and "nan" are numbers too.
/// Empty where it is none, or too large or too small for one.
inline std::optional<double> parse_number(std::string_view text) {
  double value = 0.0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace gripline
