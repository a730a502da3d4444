#include "measured/log/raw_log.hpp"

#include <algorithm>
#include <cmath>

#include "config/ascii.hpp"
#include "config/errors.hpp"
#include "measured/clock_steps.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {

void refuse(const CsvTable& table, const std::string& message, std::size_t row) {
  Diagnostic d;
  d.file = table.file.string();
  if (row != SIZE_MAX) d.line = table.line[row];
  d.message = message;
  throw InputError({d});
}

namespace {

/// Other names that logs use for a column.
struct Alias {
  const char* column;
  std::vector<std::string> also;
};
const std::vector<Alias>& aliases() {
  static const std::vector<Alias> all = {
      {"t_s", {"time", "t", "time_s", "timestamp", "time_stamp", "seconds", "t_ms", "time_ms", "stamp"}},
      {"x_m", {"x", "pos_x", "px", "x_pos", "east", "x_mm"}},
      {"y_m", {"y", "pos_y", "py", "y_pos", "north", "y_mm"}},
      {"yaw_rad", {"yaw", "heading", "psi", "theta", "phi", "yaw_deg", "heading_rad", "heading_deg"}},
      {"vx_mps", {"vx", "v_x", "v", "speed", "velocity", "vx_ms", "vx_kmh", "speed_mps"}},
      {"vy_mps", {"vy", "v_y", "vy_ms", "vy_kmh"}},
      {"yaw_rate_radps", {"yaw_rate", "yawrate", "r", "omega", "w", "gyro_z", "psi_dot", "yaw_rate_degps"}},
      {"d", {"throttle", "pedal", "duty", "motor", "u_d", "throttle_brake"}},
      {"delta_rad", {"delta", "steer", "steering", "steering_rad", "steer_rad", "steering_angle", "delta_deg"}}};
  return all;
}

/// `; did you mean "x"?` for a column under one of its other names or a similar one; else empty.
std::string meant(const CsvTable& table, const std::string& column) {
  std::vector<std::string> free;
  for (const std::string& name : table.header)
    if (std::none_of(aliases().begin(), aliases().end(), [&](const Alias& a) { return name == a.column; }))
      free.push_back(name);
  for (const Alias& a : aliases())
    for (const std::string& name : free)
      if (a.column == column && std::find(a.also.begin(), a.also.end(), lower_case(name)) != a.also.end())
        return "; did you mean \"" + name + "\"?";
  const auto near = nearest(column, free);
  return near ? "; did you mean \"" + *near + "\"?" : std::string();
}

/// The table's columns; of a file that is no table but one endless line or name, the beginning.
std::string found_names(const CsvTable& table) {
  constexpr std::size_t longest_name = 40, longest = 400;  // bytes
  std::string found;
  for (const std::string& name : table.header) {
    if (found.size() > longest) return found + ", ... (" + std::to_string(table.header.size()) + " columns)";
    std::size_t end = std::min(name.size(), longest_name);
    while (end < name.size() && end > 0 && (name[end] & 0xc0) == 0x80) --end;  // not within a letter
    const bool whole = end == name.size();
    found += (found.empty() ? "" : ", ") + name.substr(0, end) + (whole ? "" : "...");
  }
  return found;
}

void check_header(const CsvTable& table) {
  std::string missing;
  for (const Alias& a : aliases()) {
    const auto count = std::count(table.header.begin(), table.header.end(), a.column);
    if (count > 1)
      refuse(table, "column " + std::string(a.column) + " stands there " + std::to_string(count) +
                        " times; expected each column once");
    if (count == 0 && a.column != std::string("vy_mps"))
      missing += (missing.empty() ? "" : ", ") + (a.column + meant(table, a.column));
  }
  if (missing.empty()) return;
  refuse(table, "columns missing: " + missing +
                    " (needed: t_s, x_m, y_m, yaw_rad, vx_mps, yaw_rate_radps, d, delta_rad; "
                    "vy_mps may be absent; found: " +
                    found_names(table) +
                    "); a log with columns of its own needs a map (gripline import --guess LOG.csv writes one)");
}

}  // namespace

RawLog RawLog::picked(std::span<const std::size_t> rows) const {
  RawLog kept;
  for (const std::size_t i : rows) {
    kept.t.push_back(t[i]);
    kept.d.push_back(d[i]);
    kept.delta.push_back(delta[i]);
    kept.row.push_back(row[i]);
    for (std::size_t c = 0; c < channels; ++c) kept.reading.push_back(at(i, c));
  }
  return kept;
}

Finding absent_lateral_speed(const CsvTable& table) {
  return {Finding::Level::note, "vy_mps", "absent" + meant(table, "vy_mps"), "done without"};
}

RawLog read_columns(const CsvTable& table) {
  check_header(table);
  std::array<int, channels> column{};
  for (std::size_t c = 0; c < channels; ++c) column[c] = table.find(channel_info[c].column);
  const int t = table.find("t_s"), d = table.find("d"), delta = table.find("delta_rad");
  RawLog raw;
  const auto cell = [&](std::size_t r, int c) {
    return c < 0 ? not_a_number : table.at(r, static_cast<std::size_t>(c));
  };
  for (std::size_t r = 0; r < table.rows(); ++r) {
    if (!std::isfinite(cell(r, t)) || !std::isfinite(cell(r, d)) || !std::isfinite(cell(r, delta))) continue;
    raw.t.push_back(cell(r, t));
    raw.d.push_back(cell(r, d));
    raw.delta.push_back(cell(r, delta));
    raw.row.push_back(r);
    for (std::size_t c = 0; c < channels; ++c) {
      const double v = cell(r, column[c]);
      raw.reading.push_back(std::isfinite(v) ? v : not_a_number);
    }
  }
  return raw;
}

double sampling_interval(std::span<const double> t) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < t.size(); ++i) steps.push_back(t[i] - t[i - 1]);
  // The median, then refined over whole steps so that rounding of the stamps does not add up.
  double dt = upper_median(steps, 0.0);
  if (dt < shortest_step) return mean_step(steps);  // a grid as fine as bursts are would fill the memory
  double whole = 0.0, span = 0.0;
  for (const double s : steps)
    if (s < 1.5 * dt) {
      whole += 1.0;
      span += s;
    }
  if (std::abs(span / whole - dt) < 0.05 * dt) dt = span / whole;
  // A whole number of microseconds, unless the grid then runs away from the stamps: 60 Hz is none.
  const double nice = std::round(dt * 1e6) * 1e-6;
  return std::abs(nice - dt) * whole < 0.1 * dt ? nice : dt;
}

double check_time(const CsvTable& table, RawLog& raw, std::vector<Finding>& health) {
  std::vector<std::size_t> keep;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (keep.empty() || raw.t[i] > raw.t[keep.back()]) {
      keep.push_back(i);
    } else if (raw.t[i] < raw.t[keep.back()]) {
      refuse(table,
             "time runs backward from " + significant(raw.t[keep.back()], 8) + " s to " + significant(raw.t[i], 8) +
                 " s; expected rows in the order of t_s",
             raw.row[i]);
    }
  }
  if (keep.size() < raw.size()) {
    health.push_back({Finding::Level::note, "time",
                      std::to_string(raw.size() - keep.size()) + " rows repeat a time stamp", "left out"});
    raw = raw.picked(keep);
  }
  if (raw.size() < 20)
    refuse(table, "only " + std::to_string(raw.size()) + " usable rows; expected a log of at least 5 s");
  const double dt = sampling_interval(raw.t);
  if (may_be_seconds_or_milliseconds(dt))
    refuse(table, "rows are " + significant(dt) + " s apart (" + significant(1.0 / dt) +
                      " Hz); expected 0.1 s or less; if the numbers are milliseconds (" + significant(1e3 / dt, 4) +
                      " Hz), divide them by 1000");
  for (const auto& [unit, factor] : {std::pair("milliseconds", 1e3), std::pair("microseconds", 1e6)})
    if (dt > 0.9e-3 * factor && dt < 0.11 * factor && dt >= least_count)
      refuse(table,
             "t_s rises by " + significant(dt) + " from row to row: it looks like " + unit + "; expected seconds");
  if (raw.t.back() - raw.t.front() < shortest_log)
    refuse(table,
           "the log lasts " + significant(raw.t.back() - raw.t.front()) + " s; at least 5 s are needed, 60 s are good");
  if (dt > 0.1) refuse(table, "rows are " + significant(dt) + " s apart; expected 0.1 s or less");
  return dt;
}

}  // namespace gripline::measured
