#include "measured/log_file.hpp"

#include <algorithm>
#include <cmath>

#include "config/errors.hpp"
#include "measured/raw_log.hpp"
#include "util/statistics.hpp"

namespace gripline::diagnose {
namespace {

constexpr double longest_gap = 0.2;    // [s] bridged
constexpr double short_stretch = 3.0;  // [s] of a stretch between gaps
double command_at(const Raw& raw, const std::vector<double>& of, double t, std::size_t& hint) {
  while (hint + 2 < raw.size() && raw.t[hint + 1] < t) ++hint;
  const double share = std::clamp((t - raw.t[hint]) / (raw.t[hint + 1] - raw.t[hint]), 0.0, 1.0);
  return of[hint] + share * (of[hint + 1] - of[hint]);
}

/// Rows first..last-1 on an even grid. A reading off its grid time is moved there along its own local slope.
Measured to_grid(const Raw& raw, std::size_t first, std::size_t last, double dt, double start) {
  Measured log;
  log.dt = dt;
  log.t0 = raw.t[first] - start;
  const auto n = static_cast<std::size_t>(std::round((raw.t[last - 1] - raw.t[first]) / dt)) + 1;
  log.reading.assign(n * channels, nothing_read);
  log.command.resize(n);
  log.guessed.assign(n, true);
  std::size_t hint = first;
  for (std::size_t k = 0; k < n; ++k) {
    const double t = raw.t[first] + static_cast<double>(k) * dt;
    log.command[k] = {command_at(raw, raw.d, t, hint), command_at(raw, raw.delta, t, hint)};
  }
  for (std::size_t i = first; i < last; ++i) {
    const double position = (raw.t[i] - raw.t[first]) / dt;
    const auto k = static_cast<std::size_t>(std::max(0.0, std::round(position)));
    if (k >= n) continue;
    log.guessed[k] = false;
    const double late = (position - static_cast<double>(k)) * dt;
    for (std::size_t c = 0; c < channels; ++c) {
      double y = raw.reading[i * channels + c];
      if (std::abs(late) > 1e-3 * dt && i > first + 1 && i + 2 < last) {
        const double rise = raw.reading[(i + 2) * channels + c] - raw.reading[(i - 2) * channels + c];
        const double change = late * rise / (raw.t[i + 2] - raw.t[i - 2]);
        if (std::isfinite(change)) y -= change;
      }
      log.reading[k * channels + c] = y;
    }
  }
  if (std::none_of(log.guessed.begin(), log.guessed.end(), [](bool g) { return g; })) log.guessed.clear();
  return log;
}

/// Standing starts and stops: slip angles mean little there, and no model of the tyres is asked about them. Their rows
/// go, which cuts the log.
void leave_out_slow(Raw& raw, double v_ref, double dt, std::vector<Health>& health) {
  const double slowest = 0.2 * v_ref;
  std::vector<std::size_t> fast;
  for (std::size_t i = 0; i < raw.size(); ++i)
    if (!(raw.at(i, 3) < slowest)) fast.push_back(i);
  Raw kept = raw.picked(fast);
  if (kept.size() == raw.size()) return;
  health.push_back(
      {"speed",
       short_text(static_cast<double>(raw.size() - kept.size()) * dt) + " s below " + short_text(slowest) + " m/s",
       "left out", Health::Level::note});
  raw = std::move(kept);
}

}  // namespace

LogFile read_log_file(const std::filesystem::path& file, const LogExpectations& expected) {
  const CsvTable table = read_csv(file, true);
  LogFile log;
  log.name = file.filename().string();
  Raw raw = read_columns(table);
  const std::size_t unusable = table.rows() - raw.size();
  if (unusable > 0)
    log.health.push_back(
        {"rows", std::to_string(unusable) + " without time or command", "left out", Health::Level::note});
  const double dt = check_time(table, raw, log.health);
  check_yaw_is_radians(table, raw);
  std::size_t missing = 0;
  for (std::size_t i = 0; i < raw.size(); ++i)
    for (std::size_t c = 0; c < channels; ++c)
      missing += std::isnan(raw.at(i, c)) && table.find(channel_columns[c]) >= 0;
  if (missing > 0)
    log.health.push_back({"readings", std::to_string(missing) + " missing", "left out", Health::Level::note});
  drop_gross_outliers(raw, log.health);
  unwrap_yaw(raw, log.health);
  check_units(table, raw, dt, expected, log.health);
  if (expected.road != nullptr) check_place(table, raw, *expected.road);
  if (table.find("vy_mps") < 0) log.health.push_back(absent_lateral_speed(table));
  if (const std::size_t dropped = drop_outliers(raw); dropped > 0) {
    const double share = static_cast<double>(dropped) / static_cast<double>(raw.size() * channels);
    log.health.push_back({"outliers", std::to_string(dropped) + " readings (" + short_text(100.0 * share, 2) + " %)",
                          "left out", share > 0.05 ? Health::Level::bad : Health::Level::note});
  }
  const double begin = raw.t.front();
  leave_out_slow(raw, expected.v_ref, dt, log.health);
  double jitter = 0.0;
  std::size_t gone = 0, first = 0, short_ones = 0;
  for (std::size_t i = 1; i <= raw.size(); ++i) {
    const double step = i < raw.size() ? raw.t[i] - raw.t[i - 1] : 1e9;
    if (step <= longest_gap + 0.5 * dt) {
      gone += static_cast<std::size_t>(std::max(0.0, std::round(step / dt) - 1.0));
      jitter = std::max(jitter, std::abs(step / dt - std::round(step / dt)));
      continue;
    }
    if (i > first && raw.t[i - 1] - raw.t[first] >= short_stretch)
      log.stretches.push_back(to_grid(raw, first, i, dt, begin));
    else
      ++short_ones;
    first = i;
  }
  if (log.stretches.empty()) refuse(table, "no stretch of 3 s without a gap of more than 0.2 s");
  for (const Measured& m : log.stretches) log.seconds += static_cast<double>(m.size() - 1) * dt;
  if (log.seconds < shortest_log)
    refuse(table, "only " + short_text(log.seconds) + " s without long gaps; at least 5 s are needed");
  if (gone > 0) log.health.push_back({"rows", std::to_string(gone) + " dropped", "bridged", Health::Level::note});
  if (log.stretches.size() > 1 || short_ones > 0)
    log.health.push_back({"gaps", std::to_string(log.stretches.size() + short_ones - 1) + " longer than 0.2 s",
                          "cut there", Health::Level::note});
  if (jitter > 0.02)
    log.health.push_back({"time", "steps vary by " + short_text(100.0 * jitter, 2) + " % of " + short_text(dt) + " s",
                          "brought to an even grid", Health::Level::note});
  if (log.seconds < 20.0)
    log.health.push_back(
        {"length", short_text(log.seconds) + " s", "little to tell effects apart; 60 s are good", Health::Level::note});
  return log;
}

bool same_content(const LogFile& a, const LogFile& b) {
  const auto same = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  return std::equal(a.stretches.begin(), a.stretches.end(), b.stretches.begin(), b.stretches.end(),
                    [&](const Measured& x, const Measured& y) {
                      return std::equal(x.reading.begin(), x.reading.end(), y.reading.begin(), y.reading.end(), same) &&
                             std::equal(x.command.begin(), x.command.end(), y.command.begin(), y.command.end(),
                                        [](const auto& c, const auto& e) { return c.d == e.d && c.delta == e.delta; });
                    });
}

std::vector<LogFile> each_once(std::span<const LogFile> logs) {
  std::vector<LogFile> once;
  for (const LogFile& log : logs) {
    const auto twin = std::find_if(once.begin(), once.end(), [&](const LogFile& o) { return same_content(o, log); });
    if (twin == once.end())
      once.push_back(log);
    else
      twin->health.push_back(
          {"logs", log.name + " holds the same rows as " + twin->name, "used once", Health::Level::note});
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

Channels estimate_noise(std::span<const Measured> stretches) {
  Channels sigma;
  for (std::size_t c = 0; c < channels; ++c) {
    std::vector<double> squares;
    for (const Measured& m : stretches)
      for (std::size_t k = 4; k < m.size(); ++k) {
        const auto y = [&](std::size_t back) { return m.reading[(k - back) * channels + c]; };
        const double difference = y(0) - 4.0 * y(1) + 6.0 * y(2) - 4.0 * y(3) + y(4);
        if (std::isfinite(difference)) squares.push_back(difference * difference / 70.0);
      }
    // The smaller half is hardly touched by the car's own quick motions: the median of a chi-square with one degree of
    // freedom is 0.4549 of its mean.
    sigma[c] = std::sqrt(upper_median(squares, nothing_read) / 0.4549);
  }
  return sigma;
}

}  // namespace gripline::diagnose
