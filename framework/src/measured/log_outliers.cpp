#include <algorithm>
#include <cmath>
#include <numbers>

#include "measured/raw_log.hpp"
#include "util/statistics.hpp"

namespace gripline::diagnose {
namespace {

constexpr std::size_t yaw = 2;

/// The difference of two readings of a channel; headings differ by less than half a turn, wrapped or not.
double apart(std::size_t channel, double a, double b) {
  return channel == yaw ? std::remainder(a - b, 2.0 * std::numbers::pi) : a - b;
}

/// How far each reading lies from the median of those around it.
std::vector<double> off_neighbours(const Raw& raw, std::size_t c) {
  constexpr std::size_t reach = 4;
  std::vector<double> off(raw.size(), nothing_read), around;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (std::isnan(raw.at(i, c))) continue;
    around.clear();
    for (std::size_t j = i - std::min(i, reach); j <= std::min(raw.size() - 1, i + reach); ++j)
      if (j != i && !std::isnan(raw.at(j, c))) around.push_back(apart(c, raw.at(i, c), raw.at(j, c)));
    if (around.size() >= 4) off[i] = upper_median(around, 0.0);
  }
  return off;
}

/// What a channel changes by in the ordinary course of things, so that more is no motion of a car.
double ordinary_change(const Raw& raw, std::size_t c) {
  if (c == yaw) return 0.3;
  std::vector<double> values;
  if (c < yaw) {  // nine rows' way
    for (std::size_t i = 8; i < raw.size(); ++i)
      if (const double way = raw.at(i, c) - raw.at(i - 8, c); std::isfinite(way)) values.push_back(std::abs(way));
    return order_statistic(values, values.size() * 9 / 10, 0.0);
  }
  for (std::size_t i = 0; i < raw.size(); ++i)
    if (!std::isnan(raw.at(i, c))) values.push_back(raw.at(i, c));
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return 0.5 * (values[values.size() * 9 / 10] - values[values.size() / 10]);
}

/// Far from all around it, and reached and left by a jump: a quick motion of the car comes and goes by steps.
std::vector<bool> gross(const Raw& raw, std::size_t c) {
  const std::vector<double> off = off_neighbours(raw, c);
  std::vector<double> sizes;
  for (const double o : off)
    if (!std::isnan(o)) sizes.push_back(std::abs(o));
  const double limit = ordinary_change(raw, c) + 7.0 * 1.4826 * upper_median(sizes, 0.0);
  const auto far = [&](std::size_t i) { return std::abs(off[i]) > limit; };
  std::vector<bool> out(raw.size(), false);
  for (std::size_t i = 0; limit > 0.0 && i < raw.size(); ++i) {
    if (!far(i)) continue;
    const auto jumps_from = [&](std::ptrdiff_t step) {
      for (auto j = static_cast<std::ptrdiff_t>(i) + step; j >= 0 && j < static_cast<std::ptrdiff_t>(raw.size());
           j += step) {
        const auto k = static_cast<std::size_t>(j);
        if (std::isnan(off[k]) || far(k)) continue;
        return std::abs(apart(c, raw.at(i, c), raw.at(k, c))) > 0.6 * std::abs(off[i]);
      }
      return true;
    };
    out[i] = jumps_from(-1) && jumps_from(1);
  }
  return out;
}

/// A command that stands apart from both its neighbours by more than they from each other.
bool command_jumps(const std::vector<double>& command, std::size_t i, double least) {
  if (i == 0 || i + 1 >= command.size()) return true;
  const double before = command[i] - command[i - 1], after = command[i + 1] - command[i];
  return before * after < 0.0 && std::min(std::abs(before), std::abs(after)) > least;
}

/// Rows that say nothing: every reading exactly zero, which noise never lets a driving car's sensors show.
void drop_blank_rows(Raw& raw, std::vector<Health>& health) {
  std::vector<std::size_t> written;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    std::size_t zeros = 0, others = 0;
    for (std::size_t c = 0; c < channels; ++c) {
      zeros += raw.at(i, c) == 0.0;
      others += std::isfinite(raw.at(i, c)) && raw.at(i, c) != 0.0;
    }
    if (zeros == 0 || others > 0) written.push_back(i);
  }
  const std::size_t blank = raw.size() - written.size();
  // Half a log of zeros is a car that stands.
  if (blank == 0 || 2 * blank > raw.size()) return;
  raw = raw.picked(written);
  health.push_back({"rows", std::to_string(blank) + " without any reading", "left out", Health::Level::note});
}

/// Rows whose commands no car takes: a few are faults, many are a unit.
void drop_impossible_commands(Raw& raw, std::vector<Health>& health) {
  std::vector<std::size_t> good;
  for (std::size_t i = 0; i < raw.size(); ++i)
    if (std::abs(raw.d[i]) <= 1.5 && std::abs(raw.delta[i]) <= 1.6) good.push_back(i);
  const std::size_t bad = raw.size() - good.size();
  if (bad == 0 || bad * 33 > raw.size()) return;
  raw = raw.picked(good);
  health.push_back(
      {"commands", std::to_string(bad) + " rows beyond what a car can be told", "left out", Health::Level::note});
}

}  // namespace

void drop_gross_outliers(Raw& raw, std::vector<Health>& health) {
  drop_blank_rows(raw, health);
  drop_impossible_commands(raw, health);
  std::vector<std::size_t> count(raw.size(), 0);
  std::size_t readings = 0;
  for (std::size_t c = 0; c < channels; ++c) {
    std::vector<double> sizes;
    for (std::size_t i = 0; i < raw.size(); ++i)
      if (!std::isnan(raw.at(i, c))) sizes.push_back(std::abs(raw.at(i, c)));
    // Beyond all sense first: such numbers would not even survive a subtraction.
    const double senseless = 1e6 * (1.0 + upper_median(sizes, 0.0));
    std::vector<bool> out(raw.size(), false);
    for (std::size_t i = 0; i < raw.size(); ++i)
      if (std::abs(raw.at(i, c)) > senseless) {
        out[i] = true;
        raw.at(i, c) = nothing_read;
      }
    const std::vector<bool> far = gross(raw, c);
    for (std::size_t i = 0; i < raw.size(); ++i) {
      if (!out[i] && !far[i]) continue;
      raw.at(i, c) = nothing_read;
      ++count[i];
      ++readings;
    }
  }
  // Half a row gone wrong: nothing of it is believed, and its commands only when they go on smoothly.
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (count[i] >= 3) {
      for (std::size_t c = 0; c < channels; ++c) raw.at(i, c) = nothing_read;
      if (command_jumps(raw.d, i, 0.02) || command_jumps(raw.delta, i, 0.004)) continue;
    }
    kept.push_back(i);
  }
  const std::size_t rows = raw.size() - kept.size();
  if (rows > 0) {
    raw = raw.picked(kept);
    health.push_back({"outliers", std::to_string(rows) + " rows far off all around them", "left out",
                      rows * 20 > raw.size() ? Health::Level::bad : Health::Level::note});
  }
  if (readings > 0)
    health.push_back({"outliers", std::to_string(readings) + " readings far off all around them", "left out",
                      readings * 20 > raw.size() * channels ? Health::Level::bad : Health::Level::note});
}

void unwrap_yaw(Raw& raw, std::vector<Health>& health) {
  double turns = 0.0, last = nothing_read;
  std::size_t jumps = 0;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    double& heading = raw.at(i, yaw);
    if (std::isnan(heading)) continue;
    heading += turns;
    if (!std::isnan(last)) {
      const double whole = 2.0 * std::numbers::pi * std::round((heading - last) / (2.0 * std::numbers::pi));
      if (whole != 0.0) {
        heading -= whole;
        turns -= whole;
        ++jumps;
      }
    }
    last = heading;
  }
  if (jumps > 0)
    health.push_back({"yaw", "wrapped " + std::to_string(jumps) + " times", "made continuous", Health::Level::note});
}

// A spike stands out of its neighbours' quadratic.
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
    const double usual = std::max(1.4826 * upper_median(size, 0.0), 0.003 * std::sqrt(change / count));
    if (!(usual > 0.0)) continue;
    for (std::size_t i = 2; i + 2 < raw.size(); ++i) {
      // A spike of size s leaves -2/3 s beside it; a quick motion of the car does not.
      const auto beside = [&](std::size_t j) { return std::abs(off[j] / off[i] + 2.0 / 3.0) < 0.35; };
      if (!(std::abs(off[i]) > 7.0 * usual) || !beside(i - 1) || !beside(i + 1)) continue;
      raw.at(i, c) = nothing_read;
      ++dropped;
    }
  }
  return dropped;
}

}  // namespace gripline::diagnose
