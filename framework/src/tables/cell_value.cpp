#include "tables/cell_value.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>

#include "config/ascii.hpp"
#include "util/numbers.hpp"

namespace gripline {

std::string_view trim_cell(std::string_view text) {
  // A blank that does not break is two bytes in UTF-8; the second of them alone ends letters too.
  constexpr std::string_view unbroken = "\xc2\xa0";
  for (std::size_t before = text.size() + 1; text.size() < before;) {
    before = text.size();
    text = trim(text);
    if (text.starts_with(unbroken)) text.remove_prefix(unbroken.size());
    if (text.ends_with(unbroken)) text.remove_suffix(unbroken.size());
  }
  return text;
}

namespace {

/// "12:34:56.7" or "12:34.5" in seconds.
double read_clock(std::string_view cell) {
  double seconds = 0.0;
  int parts = 0;
  while (true) {
    const std::size_t colon = cell.find(':');
    const std::string_view part = cell.substr(0, colon);
    double value = 0.0;
    const auto [stop, code] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (code != std::errc() || stop != part.data() + part.size() || value < 0.0) return not_a_number;
    seconds = seconds * 60.0 + value;
    ++parts;
    if (colon == std::string_view::npos) break;
    cell.remove_prefix(colon + 1);
  }
  return parts == 2 || parts == 3 ? seconds : not_a_number;
}

/// Reads a whole number of `digits` digits off the front.
bool take_digits(std::string_view& text, std::size_t digits, int& value) {
  if (text.size() < digits) return false;
  const auto [stop, code] = std::from_chars(text.data(), text.data() + digits, value);
  if (code != std::errc() || stop != text.data() + digits || value < 0) return false;
  text.remove_prefix(digits);
  return true;
}

bool take(std::string_view& text, std::string_view characters) {
  if (text.empty() || characters.find(text.front()) == std::string_view::npos) return false;
  text.remove_prefix(1);
  return true;
}

/// What "Z", "UTC", "+02:00", "-0200" or "+02" at the end of a time is east of Greenwich [s], which is taken off
/// `clock`; NaN for something else there.
double take_zone(std::string_view& clock) {
  for (const std::string_view greenwich : {"Z", "UTC"})
    if (clock.ends_with(greenwich)) {
      clock = trim_cell(clock.substr(0, clock.size() - greenwich.size()));
      return 0.0;
    }
  const std::size_t sign = clock.find_last_of("+-");
  if (sign == std::string_view::npos) return 0.0;
  std::string_view zone = clock.substr(sign + 1);
  int hours = 0, minutes = 0;
  if (!take_digits(zone, 2, hours)) return not_a_number;
  take(zone, ":");
  if (!zone.empty() && (!take_digits(zone, 2, minutes) || !zone.empty())) return not_a_number;
  const double east = clock[sign] == '-' ? -1.0 : 1.0;
  clock = trim_cell(clock.substr(0, sign));
  return east * 60.0 * (60.0 * hours + minutes);
}

/// "2018-04-08 10:31:37.5", "2018-04-08T10:31:37Z" or "...+02:00" in seconds since 1970 (ISO 8601).
double read_date_time(std::string_view cell) {
  using namespace std::chrono;
  int y = 0, m = 0, d = 0;
  if (!take_digits(cell, 4, y) || !take(cell, "-/") || !take_digits(cell, 2, m) || !take(cell, "-/") ||
      !take_digits(cell, 2, d) || !take(cell, " T"))
    return not_a_number;
  const year_month_day date{year(y), month(static_cast<unsigned>(m)), day(static_cast<unsigned>(d))};
  if (!date.ok()) return not_a_number;
  const double zone = take_zone(cell);
  if (std::count(cell.begin(), cell.end(), ':') != 2) return not_a_number;
  const double day_begin = static_cast<double>(duration_cast<seconds>(sys_days(date).time_since_epoch()).count());
  return day_begin + read_clock(cell) - zone;
}

}  // namespace

bool is_missing(std::string_view cell) {
  constexpr std::array<std::string_view, 18> words = {"",     "-",    "--",  "nan", "NaN",  "NAN",
                                                      "-nan", "-NaN", "NA",  "na",  "null", "NULL",
                                                      "None", "none", "N/A", "n/a", "#N/A", "#NV"};
  return std::find(words.begin(), words.end(), cell) != words.end();
}

double read_cell(std::string_view cell, bool decimal_comma) {
  cell = trim_cell(cell);
  if (cell.starts_with('+')) cell.remove_prefix(1);
  std::array<char, 64> copy{};
  // ISO 8601 lets fractions of a second follow a comma, whatever the numbers of the table do.
  const bool comma = decimal_comma || cell.find(':') != std::string_view::npos;
  if (comma && cell.find(',') != std::string_view::npos && cell.size() < copy.size()) {
    std::replace_copy(cell.begin(), cell.end(), copy.begin(), ',', '.');
    cell = std::string_view(copy.data(), cell.size());
  }
  double number = 0.0;
  const auto [stop, code] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
  if (code == std::errc() && stop == cell.data() + cell.size()) return std::isfinite(number) ? number : not_a_number;
  if (cell == "true" || cell == "TRUE" || cell == "True") return 1.0;
  if (cell == "false" || cell == "FALSE" || cell == "False") return 0.0;
  if (cell.find(':') == std::string_view::npos) return not_a_number;
  const double clock = read_clock(cell);
  return std::isnan(clock) ? read_date_time(cell) : clock;
}

}  // namespace gripline
