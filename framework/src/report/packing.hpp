// Columns of numbers as compact text inside a page, and JSON that cannot end its own script element.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace gripline::report {

/// RFC 4648, with padding.
std::string base64(std::span<const std::uint8_t> bytes);

/// How exactly a column is kept.
enum class Precision {
  single,  ///< 4 bytes: the value less the column's middle as a 32-bit float
  half     ///< 2 bytes: 65535 levels from the smallest to the largest value
};

/// Values beyond this are not drawn: no axis that holds them shows anything else.
inline constexpr double drawable_limit = 1e9;

/// One column as JSON: {"n", "k", "o", "s", "b"}. k = "c": every value is o. k = "u": value i is o + s i. k = "f": o +
/// the i-th little-endian float32 of the base64 text b. k = "h": o + s times the i-th int16 of b, -32768 meaning no
/// value. NaN, infinities and values beyond drawable_limit are gaps.
nlohmann::json pack(std::span<const double> values, Precision precision);

/// A value as JSON text without any '<', so that neither "</script>" nor "<!--" can occur; invalid UTF-8 is replaced.
std::string script_safe(const nlohmann::json& value);

/// Text as HTML content or attribute value.
std::string html_escaped(std::string_view text);

/// A number, or null when it is not finite.
nlohmann::json number_or_null(double value);

}  // namespace gripline::report
