#include "measured/log/log_file.hpp"

#include <algorithm>
#include <cmath>

#include "config/errors.hpp"
#include "measured/log/log_checks.hpp"
#include "measured/log/log_outliers.hpp"
#include "measured/log/raw_log.hpp"
#include "measured/log/repeated_readings.hpp"
#include "measured/readings/bridged_readings.hpp"
#include "measured/session/session_windows.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {
namespace {

constexpr double longest_bridged = 0.2;  // [s]: longer ones are not bridged
constexpr double short_stretch = 3.0;    // [s]: shorter ones between gaps are left out

/// A command at time t [s]; `hint` is a row at or before it and moves on.
double command_at(const RawLog& raw, const std::vector<double>& of, double t, std::size_t& hint) {
  while (hint + 2 < raw.size() && raw.t[hint + 1] < t) ++hint;
  const double share = std::clamp((t - raw.t[hint]) / (raw.t[hint + 1] - raw.t[hint]), 0.0, 1.0);
  return of[hint] + share * (of[hint + 1] - of[hint]);
}

/// Rows first..last-1 on an even grid. A reading off its grid time is moved there along its own local slope; of rows
/// that fall on one sample each channel has its last reading.
Log to_grid(const RawLog& raw, std::size_t first, std::size_t last, double dt, double start) {
  Log log;
  log.dt = dt;
  log.t0 = raw.t[first] - start;
  const auto n = static_cast<std::size_t>(std::round((raw.t[last - 1] - raw.t[first]) / dt)) + 1;
  log.reading.assign(n * channels, not_a_number);
  log.command.resize(n);
  log.interpolated.assign(n, true);
  std::size_t hint = first;
  for (std::size_t k = 0; k < n; ++k) {
    const double t = raw.t[first] + static_cast<double>(k) * dt;
    log.command[k] = {command_at(raw, raw.d, t, hint), command_at(raw, raw.delta, t, hint)};
  }
  for (std::size_t i = first; i < last; ++i) {
    const double position = (raw.t[i] - raw.t[first]) / dt;
    const auto k = static_cast<std::size_t>(std::max(0.0, std::round(position)));
    if (k >= n) continue;
    log.interpolated[k] = false;
    const double late = (position - static_cast<double>(k)) * dt;
    for (std::size_t c = 0; c < channels; ++c) {
      double y = raw.reading[i * channels + c];
      if (std::isnan(y)) continue;
      if (std::abs(late) > 1e-3 * dt && i > first + 1 && i + 2 < last) {
        const double rise = raw.reading[(i + 2) * channels + c] - raw.reading[(i - 2) * channels + c];
        const double change = late * rise / (raw.t[i + 2] - raw.t[i - 2]);
        if (std::isfinite(change)) y -= change;
      }
      log.reading[k * channels + c] = y;
    }
  }
  if (std::none_of(log.interpolated.begin(), log.interpolated.end(), [](bool g) { return g; }))
    log.interpolated.clear();
  return log;
}

/// Rows slower than `slow_share` of v_ref, where slip angles are ill-conditioned, are left out, which cuts the log
/// there. Of rows without a speed those around it tell.
void leave_out_slow(RawLog& raw, double v_ref, double dt, std::vector<Finding>& health) {
  constexpr double longest_gap = 0.5;  // [s] between speeds
  const double slowest = slow_share * v_ref;
  const std::vector<double> bridged = bridged_readings(raw.t, raw.reading, longest_gap);
  std::vector<std::size_t> fast;
  for (std::size_t i = 0; i < raw.size(); ++i)
    if (!(bridged[i * channels + Channel::vx] < slowest)) fast.push_back(i);
  RawLog kept = raw.picked(fast);
  if (kept.size() == raw.size()) return;
  health.push_back(
      {Finding::Level::note, "speed",
       significant(static_cast<double>(raw.size() - kept.size()) * dt) + " s below " + significant(slowest) + " m/s",
       "left out"});
  raw = std::move(kept);
}

/// Readings that the file has a column for but no number.
void note_missing(const CsvTable& table, const RawLog& raw, std::vector<Finding>& health) {
  std::size_t missing = 0;
  for (std::size_t i = 0; i < raw.size(); ++i)
    for (std::size_t c = 0; c < channels; ++c)
      missing += std::isnan(raw.at(i, c)) && table.find(channel_info[c].column) >= 0;
  if (missing > 0)
    health.push_back({Finding::Level::note, "readings", std::to_string(missing) + " missing", "left out"});
}

/// What is written but was not read. What stands still goes first: it is longer than any pace.
void leave_out_repeated(RawLog& raw, double dt, double slowest, std::vector<Finding>& health) {
  leave_out_constant_lateral_speed(raw, health);
  leave_out_standing(raw, slowest, health);
  leave_out_repeats(raw, dt, slowest, health);
}

void leave_out_spikes(RawLog& raw, std::vector<Finding>& health) {
  const std::size_t dropped = drop_outliers(raw);
  if (dropped == 0) return;
  const double share = static_cast<double>(dropped) / static_cast<double>(raw.size() * channels);
  health.push_back({share > 0.05 ? Finding::Level::bad : Finding::Level::note, "outliers",
                    std::to_string(dropped) + " readings (" + significant(100.0 * share, 2) + " %)", "left out"});
}

/// A log cut where it has gaps.
struct Cut {
  std::vector<Log> stretches;
  std::size_t too_short = 0;     // stretches left out
  std::size_t dropped_rows = 0;  // bridged
  double jitter = 0.0;           // largest deviation of a step from a whole number of dt, over dt
};

/// `begin`: time of the log's first row [s].
Cut cut_at_gaps(const RawLog& raw, double dt, double begin) {
  Cut cut;
  std::size_t first = 0;
  for (std::size_t i = 1; i <= raw.size(); ++i) {
    const double step = i < raw.size() ? raw.t[i] - raw.t[i - 1] : 1e9;
    if (step <= longest_bridged + 0.5 * dt) {
      cut.dropped_rows += static_cast<std::size_t>(std::max(0.0, std::round(step / dt) - 1.0));
      cut.jitter = std::max(cut.jitter, std::abs(step / dt - std::round(step / dt)));
      continue;
    }
    if (i > first && raw.t[i - 1] - raw.t[first] >= short_stretch)
      cut.stretches.push_back(to_grid(raw, first, i, dt, begin));
    else
      ++cut.too_short;
    first = i;
  }
  return cut;
}

void note_cut(const Cut& cut, double dt, double seconds, std::vector<Finding>& health) {
  if (cut.dropped_rows > 0)
    health.push_back({Finding::Level::note, "rows", std::to_string(cut.dropped_rows) + " dropped", "bridged"});
  if (cut.stretches.size() > 1 || cut.too_short > 0)
    health.push_back({Finding::Level::note, "gaps",
                      std::to_string(cut.stretches.size() + cut.too_short - 1) + " longer than 0.2 s", "cut there"});
  if (cut.jitter > 0.02)
    health.push_back({Finding::Level::note, "time",
                      "steps vary by " + significant(100.0 * cut.jitter, 2) + " % of " + significant(dt) + " s",
                      "brought to an even grid"});
  if (seconds < 20.0)
    health.push_back({Finding::Level::note, "length", significant(seconds) + " s",
                      "little data to identify effects; 60 s are good"});
}

Cut cleaned_and_cut(RawLog& raw, double dt, double v_ref, std::vector<Finding>& health) {
  leave_out_spikes(raw, health);
  const double begin = raw.t.front();
  leave_out_slow(raw, v_ref, dt, health);
  return cut_at_gaps(raw, dt, begin);
}

RawLog raw_of(const Session& session) {
  RawLog raw;
  raw.t = session.t;
  raw.reading = session.reading;
  for (std::size_t i = 0; i < session.rows(); ++i) {
    raw.row.push_back(i);
    raw.d.push_back(session.command[i].d);
    raw.delta.push_back(session.command[i].delta);
  }
  return raw;
}

}  // namespace

LogFile on_even_grid(const Session& session, double v_ref) {
  const double dt = sampling_interval(session.t);
  LogFile log;
  log.name = session.name;
  RawLog raw = raw_of(session);
  drop_blank_rows(raw, log.health);
  drop_gross_outliers(raw, log.health);
  unwrap_yaw(raw, log.health);
  Cut cut = cleaned_and_cut(raw, dt, v_ref, log.health);
  log.stretches = std::move(cut.stretches);
  for (const Log& stretch : log.stretches) log.seconds += static_cast<double>(stretch.size() - 1) * dt;
  return log;
}

LogFile read_log_file(const std::filesystem::path& file, const LogExpectations& expected) {
  const CsvTable table = read_csv(file, true, true);
  LogFile log;
  log.name = file.filename().string();
  RawLog raw = read_columns(table);
  if (table.cut_line > 0)
    log.health.push_back({Finding::Level::note, "rows",
                          "the last one, line " + std::to_string(table.cut_line) + ", ends early", "left out"});
  const std::size_t unusable = table.rows() - raw.size();
  if (unusable > 0)
    log.health.push_back(
        {Finding::Level::note, "rows", std::to_string(unusable) + " without time or command", "left out"});
  const double dt = check_time(table, raw, log.health);
  check_yaw_is_radians(table, raw);
  note_missing(table, raw, log.health);
  drop_blank_rows(raw, log.health);
  leave_out_repeated(raw, dt, slow_share * expected.v_ref, log.health);
  drop_gross_outliers(raw, log.health);
  unwrap_yaw(raw, log.health);
  check_units(table, raw, expected, log.health);
  if (expected.road != nullptr) check_place(table, raw, *expected.road);
  if (table.find("vy_mps") < 0) log.health.push_back(absent_lateral_speed(table));
  const std::size_t rows = raw.size();
  Cut cut = cleaned_and_cut(raw, dt, expected.v_ref, log.health);
  const std::string driven = raw.size() < rows ? " at " + significant(slow_share * expected.v_ref) +
                                                     " m/s or faster, a fifth of the car's v_ref"
                                               : "";
  if (cut.stretches.empty()) refuse(table, "no stretch of 3 s without a gap of more than 0.2 s" + driven);
  for (const Log& stretch : cut.stretches) log.seconds += static_cast<double>(stretch.size() - 1) * dt;
  if (log.seconds < shortest_log)
    refuse(table, "only " + significant(log.seconds) + " s without long gaps" + driven + "; at least 5 s are needed");
  note_cut(cut, dt, log.seconds, log.health);
  log.stretches = std::move(cut.stretches);
  return log;
}

bool same_content(const LogFile& a, const LogFile& b) {
  return std::ranges::equal(a.stretches, b.stretches, [](const Log& x, const Log& y) {
    return same_readings(x.reading, y.reading) && same_commands(x.command, y.command);
  });
}

std::vector<LogFile> each_once(std::span<const LogFile> logs) {
  std::vector<LogFile> once;
  for (const LogFile& log : logs) {
    const auto same = std::find_if(once.begin(), once.end(), [&](const LogFile& o) { return same_content(o, log); });
    if (same == once.end())
      once.push_back(log);
    else
      same->health.push_back(
          {Finding::Level::note, "logs", log.name + " holds the same rows as " + same->name, "used once"});
  }
  return once;
}

void check_held_out(std::span<const LogFile> logs, std::span<const LogFile> held_out) {
  for (const LogFile& held : held_out)
    for (const LogFile& log : logs)
      if (same_content(held, log))
        throw InputError("--held-out " + held.name + " holds the same rows as the log " + log.name +
                         " that is fitted; expected a log that is not");
}

}  // namespace gripline::measured
