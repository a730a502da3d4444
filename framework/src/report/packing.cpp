#include "report/packing.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace gripline::report {
namespace {

bool drawable(double value) { return std::abs(value) <= drawable_limit; }

struct ValueRange {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  bool gaps = false;
};

ValueRange range_of(std::span<const double> values) {
  ValueRange range;
  for (const double value : values) {
    if (!drawable(value)) {
      range.gaps = true;
      continue;
    }
    range.low = std::min(range.low, value);
    range.high = std::max(range.high, value);
  }
  return range;
}

/// The step of an equally spaced column to within a part in a million of the step; 0 if it is not one.
double uniform_step(std::span<const double> values) {
  if (values.size() < 3) return 0;
  const double step = (values.back() - values.front()) / static_cast<double>(values.size() - 1);
  if (!(std::abs(step) > 0) || !drawable(step)) return 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!(std::abs(values[i] - values.front() - step * static_cast<double>(i)) <= 1e-6 * std::abs(step))) return 0;
  return step;
}

void append(std::vector<std::uint8_t>& bytes, std::uint32_t word, int count) {
  for (int i = 0; i < count; ++i) bytes.push_back(static_cast<std::uint8_t>(word >> (8 * i)));
}

// A spread below rounding of the values themselves is a constant.
bool is_constant(const ValueRange& range) {
  const double spread = range.high - range.low;
  constexpr double least = 1e-300;  // its 65534th part is still a number
  return !range.gaps && (spread <= 1e-12 * std::max(std::abs(range.low), std::abs(range.high)) || spread < least);
}

}  // namespace

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text((bytes.size() + 2) / 3 * 4, '=');
  std::size_t out = 0;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t word = 0;
    for (std::size_t j = 0; j < 3; ++j) word = word << 8 | (j < count ? bytes[i + j] : 0u);
    for (std::size_t j = 0; j < 4; ++j, ++out)
      if (j <= count) text[out] = digits[word >> (6 * (3 - j)) & 63u];
  }
  return text;
}

nlohmann::json pack(std::span<const double> values, Precision precision) {
  nlohmann::json column = {{"n", values.size()}};
  const ValueRange range = range_of(values);
  if (!(range.low <= range.high)) {
    column["k"] = "c";
    column["o"] = nullptr;
    return column;
  }
  const double step = range.gaps ? 0 : uniform_step(values);
  if (is_constant(range) || step != 0) {
    column["k"] = step != 0 && !is_constant(range) ? "u" : "c";
    column["o"] = values.front();
    column["s"] = step;
    return column;
  }
  const double middle = range.low + (range.high - range.low) / 2;
  const double level = (range.high - range.low) / 65534;
  std::vector<std::uint8_t> bytes;
  bytes.reserve(values.size() * 4);
  for (const double value : values) {
    if (precision == Precision::single) {
      const float rest = drawable(value) ? static_cast<float>(value - middle) : std::numeric_limits<float>::quiet_NaN();
      append(bytes, std::bit_cast<std::uint32_t>(rest), 4);
    } else {
      const long code = drawable(value) ? std::lround((value - middle) / level) : -32768;
      append(bytes, static_cast<std::uint32_t>(code), 2);
    }
  }
  column["k"] = precision == Precision::single ? "f" : "h";
  column["o"] = middle;
  if (precision == Precision::half) column["s"] = level;
  column["b"] = base64(bytes);
  return column;
}

std::string script_safe(const nlohmann::json& value) {
  const std::string text = value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    if (c == '<')
      safe += "\\u003c";  // '<' stands in JSON strings only
    else
      safe += c;
  }
  return safe;
}

std::string html_escaped(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      case '\'':
        safe += "&#39;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

nlohmann::json number_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

}  // namespace gripline::report
