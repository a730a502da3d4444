#include "log_file.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "../config/errors.hpp"
#include "../csv.hpp"

namespace gripline::diagnose {
namespace {

constexpr std::array<const char*, 6> channel_columns = {"x_m", "y_m", "yaw_rad", "vx_mps", "vy_mps", "yaw_rate_radps"};
constexpr std::size_t vy = 4;
constexpr double shortest = 5.0;       // [s] of a log
constexpr double longest_gap = 0.2;    // [s] bridged
constexpr double short_stretch = 3.0;  // [s] of a stretch between gaps
const double nan_value = std::numeric_limits<double>::quiet_NaN();

std::string text(double value, int digits = 3) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.*g", digits, value);
  return buffer;
}

[[noreturn]] void refuse(const CsvTable& table, const std::string& message, std::size_t row = SIZE_MAX) {
  Diagnostic d;
  d.file = table.file.string();
  if (row != SIZE_MAX) d.line = table.line[row];
  d.message = message;
  throw InputError({d});
}

/// A log row by row as written, before any grid.
struct Raw {
  std::vector<double> t, d, delta;
  std::vector<double> reading;   // rows x 6
  std::vector<std::size_t> row;  // of the table
  std::size_t size() const { return t.size(); }
  double& at(std::size_t i, std::size_t c) { return reading[i * channels + c]; }
};

Raw read_columns(const CsvTable& table) {
  std::array<int, channels> column{};
  std::string missing;
  const auto need = [&](const char* name) {
    const int i = table.find(name);
    if (i >= 0) return i;
    // What was found is listed below; only a near name belongs here.
    const std::string near = did_you_mean(name, table.header);
    missing += (missing.empty() ? "" : ", ") + (name + (near.find("did you mean") != near.npos ? near : ""));
    return i;
  };
  const int t = need("t_s");
  for (std::size_t c = 0; c < channels; ++c)
    column[c] = c == vy ? table.find(channel_columns[c]) : need(channel_columns[c]);
  const int d = need("d"), delta = need("delta_rad");
  if (!missing.empty()) {
    std::string found;
    for (const std::string& name : table.header) found += (found.empty() ? "" : ", ") + name;
    refuse(table, "columns missing: " + missing +
                      " (needed: t_s, x_m, y_m, yaw_rad, vx_mps, yaw_rate_radps, d, delta_rad; "
                      "vy_mps may be absent; found: " +
                      found + ")");
  }
  Raw raw;
  const auto cell = [&](std::size_t r, int c) { return c < 0 ? nan_value : table.at(r, static_cast<std::size_t>(c)); };
  for (std::size_t r = 0; r < table.rows(); ++r) {
    if (!std::isfinite(cell(r, t)) || !std::isfinite(cell(r, d)) || !std::isfinite(cell(r, delta))) continue;
    raw.t.push_back(cell(r, t));
    raw.d.push_back(cell(r, d));
    raw.delta.push_back(cell(r, delta));
    raw.row.push_back(r);
    for (std::size_t c = 0; c < channels; ++c) {
      const double v = cell(r, column[c]);
      raw.reading.push_back(std::isfinite(v) ? v : nan_value);
    }
  }
  return raw;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Time must run forward; equal stamps lose their later row.
double check_time(const CsvTable& table, Raw& raw, std::vector<Health>& health) {
  std::vector<std::size_t> keep;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (keep.empty() || raw.t[i] > raw.t[keep.back()]) {
      keep.push_back(i);
    } else if (raw.t[i] < raw.t[keep.back()]) {
      refuse(table,
             "time runs backward from " + text(raw.t[keep.back()], 8) + " s to " + text(raw.t[i], 8) +
                 " s; expected rows in the order of t_s",
             raw.row[i]);
    }
  }
  if (keep.size() < raw.size()) {
    health.push_back({"time", std::to_string(raw.size() - keep.size()) + " rows repeat a time stamp", "left out",
                      Health::Level::note});
    Raw kept;
    for (const std::size_t i : keep) {
      kept.t.push_back(raw.t[i]);
      kept.d.push_back(raw.d[i]);
      kept.delta.push_back(raw.delta[i]);
      kept.row.push_back(raw.row[i]);
      for (std::size_t c = 0; c < channels; ++c) kept.reading.push_back(raw.at(i, c));
    }
    raw = std::move(kept);
  }
  if (raw.size() < 20)
    refuse(table, "only " + std::to_string(raw.size()) + " usable rows; expected a log of at least 5 s");
  std::vector<double> steps;
  for (std::size_t i = 1; i < raw.size(); ++i) steps.push_back(raw.t[i] - raw.t[i - 1]);
  // The usual step, then refined over whole steps so that rounding of the stamps does not add up.
  double dt = median(steps);
  double whole = 0.0, span = 0.0;
  for (const double s : steps)
    if (s < 1.5 * dt) {
      whole += 1.0;
      span += s;
    }
  if (std::abs(span / whole - dt) < 0.05 * dt) dt = span / whole;
  const double nice = std::round(dt * 1e6) * 1e-6;  // microseconds
  if (std::abs(nice - dt) < 2e-6) dt = nice;
  if (raw.t.back() - raw.t.front() < shortest)
    refuse(table, "the log lasts " + text(raw.t.back() - raw.t.front()) + " s; at least 5 s are needed, 60 s are good");
  if (dt > 0.1) refuse(table, "rows are " + text(dt) + " s apart; expected 0.1 s or less");
  return dt;
}

/// A heading in radians is seen to jump by half a turn where it is wrapped, which is rare; one in degrees does so in
/// every quick bend.
void check_yaw_is_radians(const CsvTable& table, Raw& raw) {
  std::size_t jumps = 0;
  for (std::size_t i = 1; i < raw.size(); ++i)
    if (std::abs(raw.at(i, 2) - raw.at(i - 1, 2)) > 3.141592653589793) ++jumps;
  if (20 * jumps > raw.size())
    refuse(table, "yaw_rad jumps by more than half a turn in " + std::to_string(jumps) + " of " +
                      std::to_string(raw.size()) + " rows: it looks like degrees; expected rad");
}

void unwrap_yaw(Raw& raw, std::vector<Health>& health) {
  double turns = 0.0, last = nan_value;
  std::size_t jumps = 0;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    double& yaw = raw.at(i, 2);
    if (std::isnan(yaw)) continue;
    yaw += turns;
    if (!std::isnan(last)) {
      const double whole = 2.0 * std::numbers::pi * std::round((yaw - last) / (2.0 * std::numbers::pi));
      if (whole != 0.0) {
        yaw -= whole;
        turns -= whole;
        ++jumps;
      }
    }
    last = yaw;
  }
  if (jumps > 0)
    health.push_back({"yaw", "wrapped " + std::to_string(jumps) + " times", "made continuous", Health::Level::note});
}

/// Slope of b against a through the origin, by sums of products.
double slope(const std::vector<double>& a, const std::vector<double>& b) {
  double ab = 0.0, aa = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += a[i] * b[i];
    aa += a[i] * a[i];
  }
  return aa > 0.0 ? ab / aa : nan_value;
}

/// Channels against each other over half a second: a factor of 3.6 or 57.3 is a unit, not a car.
void check_units(const CsvTable& table, Raw& raw, double dt, const LogExpectations& expected,
                 std::vector<Health>& health) {
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::round(0.5 / dt)));
  std::vector<double> travelled, speed, turned, rate;
  for (std::size_t i = 0; i + stride < raw.size(); i += std::max<std::size_t>(1, stride / 2)) {
    if (raw.t[i + stride] - raw.t[i] > 1.5 * static_cast<double>(stride) * dt) continue;
    double v = 0.0, w = 0.0, way = 0.0;
    for (std::size_t j = i; j < i + stride; ++j) {
      const double h = raw.t[j + 1] - raw.t[j];
      v += raw.at(j, 3) * h;
      w += raw.at(j, 5) * h;
    }
    way = std::hypot(raw.at(i + stride, 0) - raw.at(i, 0), raw.at(i + stride, 1) - raw.at(i, 1));
    const double turn = raw.at(i + stride, 2) - raw.at(i, 2);
    if (std::isfinite(v) && std::isfinite(way)) {
      travelled.push_back(way);
      speed.push_back(std::abs(v));
    }
    if (std::isfinite(w) && std::isfinite(turn) && std::abs(turn) < 2.5) {
      turned.push_back(turn);
      rate.push_back(w);
    }
  }
  double top = 0.0;
  for (const double s : travelled) top = std::max(top, s / (static_cast<double>(stride) * dt));
  if (top < 0.15 * expected.v_ref)
    refuse(table, "the car is parked: it never exceeds " + text(top) + " m/s; expected driving around " +
                      text(expected.v_ref) + " m/s");
  const double v_ratio = slope(travelled, speed);
  if (v_ratio > 2.8 && v_ratio < 4.6)
    refuse(table, "vx_mps is " + text(v_ratio) + " times the speed of x_m, y_m: it looks like km/h; expected m/s");
  if (v_ratio > 1.8 && v_ratio < 2.6)
    refuse(table, "vx_mps is " + text(v_ratio) + " times the speed of x_m, y_m: it looks like mph; expected m/s");
  if (!(v_ratio > 0.6 && v_ratio < 1.6))
    refuse(table, "vx_mps is " + text(v_ratio) + " times the speed of x_m, y_m; expected about 1");
  const double w_ratio = slope(turned, rate);
  if (w_ratio > 30.0 && w_ratio < 90.0)
    refuse(table,
           "yaw_rate_radps is " + text(w_ratio) + " times the rate of yaw_rad: it looks like deg/s; expected rad/s");
  if (w_ratio > 1.0 / 90.0 && w_ratio < 1.0 / 30.0)
    refuse(table, "yaw_rad turns " + text(1.0 / w_ratio) +
                      " times as fast as yaw_rate_radps says: it looks like degrees; "
                      "expected rad");
  double largest = 0.0;
  for (const double angle : raw.delta) largest = std::max(largest, std::abs(angle));
  if (largest > 1.6) refuse(table, "delta_rad reaches " + text(largest) + ": it looks like degrees; expected rad");
  double throttle = 0.0;
  for (const double d : raw.d) throttle = std::max(throttle, std::abs(d));
  if (throttle > 1.5) refuse(table, "d reaches " + text(throttle) + ": it looks like per cent; expected -1 to 1");
  health.push_back(
      {"units", "speed over distance " + text(v_ratio) + ", yaw rate over yaw " + text(w_ratio), "plausible"});
}

/// Readings that stand alone far from their neighbours' quadratic.
std::size_t drop_outliers(Raw& raw) {
  std::size_t dropped = 0;
  for (std::size_t c = 0; c < channels; ++c) {
    std::vector<double> off(raw.size(), 0.0), size;
    for (std::size_t i = 2; i + 2 < raw.size(); ++i) {
      // Cubic through the four neighbours, at the middle.
      const double guess = (4.0 * (raw.at(i - 1, c) + raw.at(i + 1, c)) - raw.at(i - 2, c) - raw.at(i + 2, c)) / 6.0;
      off[i] = raw.at(i, c) - guess;
      if (std::isfinite(off[i])) size.push_back(std::abs(off[i]));
    }
    // Never less than a fiftieth of what the channel changes in half a second: rounding is no outlier.
    double change = 0.0, count = 1e-9;
    for (std::size_t i = 25; i < raw.size(); ++i) {
      const double step = raw.at(i, c) - raw.at(i - 25, c);
      if (!std::isfinite(step)) continue;
      change += step * step;
      count += 1.0;
    }
    const double usual = std::max(1.4826 * median(size), 0.003 * std::sqrt(change / count));
    if (!(usual > 0.0)) continue;
    for (std::size_t i = 2; i + 2 < raw.size(); ++i) {
      // A spike of size s leaves -2/3 s beside it; a quick motion of the car does not.
      const auto beside = [&](std::size_t j) { return std::abs(off[j] / off[i] + 2.0 / 3.0) < 0.35; };
      if (!(std::abs(off[i]) > 7.0 * usual) || !beside(i - 1) || !beside(i + 1)) continue;
      raw.at(i, c) = nan_value;
      ++dropped;
    }
  }
  return dropped;
}

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
  log.reading.assign(n * channels, nan_value);
  log.command.resize(n);
  std::size_t hint = first;
  for (std::size_t k = 0; k < n; ++k) {
    const double t = raw.t[first] + static_cast<double>(k) * dt;
    log.command[k] = {command_at(raw, raw.d, t, hint), command_at(raw, raw.delta, t, hint)};
  }
  for (std::size_t i = first; i < last; ++i) {
    const double position = (raw.t[i] - raw.t[first]) / dt;
    const auto k = static_cast<std::size_t>(std::max(0.0, std::round(position)));
    if (k >= n) continue;
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
  return log;
}

/// Standing starts and stops: slip angles mean little there, and no model of the tyres is asked about them. Their rows
/// go, which cuts the log.
void leave_out_slow(Raw& raw, double v_ref, double dt, std::vector<Health>& health) {
  const double slowest = 0.2 * v_ref;
  Raw kept;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (raw.at(i, 3) < slowest) continue;
    kept.t.push_back(raw.t[i]);
    kept.d.push_back(raw.d[i]);
    kept.delta.push_back(raw.delta[i]);
    kept.row.push_back(raw.row[i]);
    for (std::size_t c = 0; c < channels; ++c) kept.reading.push_back(raw.at(i, c));
  }
  if (kept.size() == raw.size()) return;
  health.push_back({"speed",
                    text(static_cast<double>(raw.size() - kept.size()) * dt) + " s below " + text(slowest) + " m/s",
                    "left out", Health::Level::note});
  raw = std::move(kept);
}

void check_place(const CsvTable& table, const Raw& raw, const Road& road) {
  std::vector<double> beyond;
  for (std::size_t i = 0; i < raw.size(); i += 10) {
    const double x = raw.reading[i * channels], y = raw.reading[i * channels + 1];
    if (std::isnan(x) || std::isnan(y)) continue;
    const CurveLocation found = road.track().locate(x, y);
    beyond.push_back(road.track().beyond_edge(found));
  }
  const double usual = median(beyond);
  // A bad driver leaves his own road by less than its width.
  if (usual > 0.5 * road.track().narrowest())
    refuse(table, "half of the log lies more than " + text(usual) + " m outside \"" + road.track().name() +
                      "\": it is from another track; give the right one with --track FILE.csv");
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
  unwrap_yaw(raw, log.health);
  check_units(table, raw, dt, expected, log.health);
  if (expected.road != nullptr) check_place(table, raw, *expected.road);
  std::size_t missing = 0;
  for (std::size_t i = 0; i < raw.size(); ++i)
    for (std::size_t c = 0; c < channels; ++c)
      missing += std::isnan(raw.at(i, c)) && table.find(channel_columns[c]) >= 0;
  if (missing > 0)
    log.health.push_back({"readings", std::to_string(missing) + " missing", "left out", Health::Level::note});
  if (table.find("vy_mps") < 0) log.health.push_back({"vy_mps", "absent", "done without", Health::Level::note});
  if (const std::size_t dropped = drop_outliers(raw); dropped > 0) {
    const double share = static_cast<double>(dropped) / static_cast<double>(raw.size() * channels);
    log.health.push_back({"outliers", std::to_string(dropped) + " readings (" + text(100.0 * share, 2) + " %)",
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
  if (log.seconds < shortest)
    refuse(table, "only " + text(log.seconds) + " s without long gaps; at least 5 s are needed");
  if (gone > 0) log.health.push_back({"rows", std::to_string(gone) + " dropped", "bridged", Health::Level::note});
  if (log.stretches.size() > 1 || short_ones > 0)
    log.health.push_back({"gaps", std::to_string(log.stretches.size() + short_ones - 1) + " longer than 0.2 s",
                          "cut there", Health::Level::note});
  if (jitter > 0.02)
    log.health.push_back({"time", "steps vary by " + text(100.0 * jitter, 2) + " % of " + text(dt) + " s",
                          "brought to an even grid", Health::Level::note});
  if (log.seconds < 20.0)
    log.health.push_back(
        {"length", text(log.seconds) + " s", "little to tell effects apart; 60 s are good", Health::Level::note});
  return log;
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
    sigma[c] = squares.empty() ? nan_value : std::sqrt(median(squares) / 0.4549);
  }
  return sigma;
}

}  // namespace gripline::diagnose
