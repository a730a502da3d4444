#include "measured/log/log_outliers.hpp"

#include <algorithm>
#include <cmath>

#include "measured/readings/unit_checks.hpp"
#include "measured/readings/unwrapped_angles.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

/// Median difference of each reading to its four neighbours on either side; not_a_number where fewer than four are
/// read.
std::vector<double> off_neighbours(const RawLog& raw, std::size_t c) {
  constexpr std::size_t reach = 4;
  std::vector<double> off(raw.size(), not_a_number), around;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (std::isnan(raw.at(i, c))) continue;
    around.clear();
    for (std::size_t j = i - std::min(i, reach); j <= std::min(raw.size() - 1, i + reach); ++j)
      if (j != i && !std::isnan(raw.at(j, c))) around.push_back(difference_of(c, raw.at(i, c), raw.at(j, c)));
    if (around.size() >= 4) off[i] = upper_median(around, 0.0);
  }
  return off;
}

/// How far a channel moves within nine rows in ordinary driving: the scale beyond which a deviation is no motion.
double ordinary_change(const RawLog& raw, std::size_t c) {
  if (c == Channel::yaw) return 0.3;
  std::vector<double> values;
  if (c < Channel::yaw) {  // distance over nine rows
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

/// Farther from its neighbours than `times` what is ordinary, and reached and left by a jump; a quick motion of the car
/// takes several samples.
std::vector<bool> far_from_neighbours(const RawLog& raw, std::size_t c, double times) {
  const std::vector<double> off = off_neighbours(raw, c);
  std::vector<double> sizes;
  for (const double o : off)
    if (!std::isnan(o)) sizes.push_back(std::abs(o));
  const double limit = times * (ordinary_change(raw, c) + 7.0 * 1.4826 * upper_median(sizes, 0.0));
  const auto far = [&](std::size_t i) { return std::abs(off[i]) > limit; };
  std::vector<bool> out(raw.size(), false);
  for (std::size_t i = 0; limit > 0.0 && i < raw.size(); ++i) {
    if (!far(i)) continue;
    const auto jumps_from = [&](std::ptrdiff_t step) {
      for (auto j = static_cast<std::ptrdiff_t>(i) + step; j >= 0 && j < static_cast<std::ptrdiff_t>(raw.size());
           j += step) {
        const auto k = static_cast<std::size_t>(j);
        if (std::isnan(off[k]) || far(k)) continue;
        return std::abs(difference_of(c, raw.at(i, c), raw.at(k, c))) > 0.6 * std::abs(off[i]);
      }
      return true;
    };
    out[i] = jumps_from(-1) && jumps_from(1);
  }
  return out;
}

/// A command that differs from both its neighbours in opposite directions by more than `least`.
bool command_jumps(const std::vector<double>& command, std::size_t i, double least) {
  if (i == 0 || i + 1 >= command.size()) return true;
  const double before = command[i] - command[i - 1], after = command[i + 1] - command[i];
  return before * after < 0.0 && std::min(std::abs(before), std::abs(after)) > least;
}

/// Rows with impossible commands are dropped when they are few; many are a wrong unit, for check_units to refuse.
void drop_impossible_commands(RawLog& raw, std::vector<Finding>& health) {
  std::vector<std::size_t> good;
  for (std::size_t i = 0; i < raw.size(); ++i)
    if (std::abs(raw.d[i]) <= most_pedal && std::abs(raw.delta[i]) <= most_steering) good.push_back(i);
  const std::size_t bad = raw.size() - good.size();
  if (bad == 0 || bad * 33 > raw.size()) return;
  raw = raw.picked(good);
  health.push_back(
      {Finding::Level::note, "commands", std::to_string(bad) + " rows beyond the range of commands", "left out"});
}

/// Leaves out readings far from all their neighbours; `count` are those of each row. Returns how many.
std::size_t drop_far_readings(RawLog& raw, std::vector<std::size_t>& count, double times = 1.0) {
  count.assign(raw.size(), 0);
  std::size_t readings = 0;
  for (std::size_t c = 0; c < channels; ++c) {
    std::vector<double> sizes;
    for (std::size_t i = 0; i < raw.size(); ++i)
      if (!std::isnan(raw.at(i, c))) sizes.push_back(std::abs(raw.at(i, c)));
    // First what would overflow in differences.
    const double senseless = 1e6 * (1.0 + upper_median(sizes, 0.0));
    std::vector<bool> out(raw.size(), false);
    for (std::size_t i = 0; i < raw.size(); ++i)
      if (std::abs(raw.at(i, c)) > senseless) {
        out[i] = true;
        raw.at(i, c) = not_a_number;
      }
    const std::vector<bool> far = far_from_neighbours(raw, c, times);
    for (std::size_t i = 0; i < raw.size(); ++i) {
      if (!out[i] && !far[i]) continue;
      raw.at(i, c) = not_a_number;
      ++count[i];
      ++readings;
    }
  }
  return readings;
}

/// A reading less that of a cubic through the four neighbours, at the middle.
double off_cubic(const RawLog& raw, std::size_t i, std::size_t c) {
  const double guess = (4.0 * (raw.at(i - 1, c) + raw.at(i + 1, c)) - raw.at(i - 2, c) - raw.at(i + 2, c)) / 6.0;
  return raw.at(i, c) - guess;
}

/// One channel's readings, by their rows.
RawLog readings_of(const Session& session, std::size_t c) {
  RawLog raw;
  for (std::size_t i = 0; i < session.rows(); ++i) {
    if (std::isnan(session.at(i, c))) continue;
    raw.t.push_back(session.t[i]);
    raw.row.push_back(i);
    for (std::size_t other = 0; other < channels; ++other)
      raw.reading.push_back(other == c ? session.at(i, c) : not_a_number);
  }
  return raw;
}

/// How far the car ordinarily goes along a channel from one reading to the next.
double ordinary_step(const RawLog& raw, std::size_t c) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < raw.size(); ++i) steps.push_back(std::abs(raw.at(i, c) - raw.at(i - 1, c)));
  return order_statistic(steps, steps.size() * 9 / 10, 0.0);
}

/// Whether reading i is reached and left by opposite jumps of more than `least` beyond the motion around it. Readings
/// that repeat until the next fix, and gaps, look like spikes to a cubic over rows, and jump once.
bool is_single_jump(const RawLog& raw, std::size_t i, std::size_t c, double least) {
  constexpr double longest = 0.35;  // [s] of seven readings
  if (raw.t[i + 3] - raw.t[i - 3] > longest) return false;
  const double slope = (raw.at(i + 2, c) - raw.at(i - 2, c)) / (raw.t[i + 2] - raw.t[i - 2]);
  const double there = raw.at(i, c) - raw.at(i - 1, c) - slope * (raw.t[i] - raw.t[i - 1]);
  const double back = raw.at(i + 1, c) - raw.at(i, c) - slope * (raw.t[i + 1] - raw.t[i]);
  const double size = std::max(least, 0.75 * std::abs(off_cubic(raw, i, c)));
  return there * back < 0.0 && std::min(std::abs(there), std::abs(back)) > size;
}

}  // namespace

std::size_t drop_gross_outliers(Session& session) {
  RawLog raw;
  raw.t = session.t;
  raw.reading = std::move(session.reading);
  std::vector<std::size_t> count;
  // Errors are judged without them: what may be a car's own hard moment, of which a model is to be judged, stays.
  constexpr double beyond_any_car = 10.0;
  const std::size_t readings = drop_far_readings(raw, count, beyond_any_car);
  session.reading = std::move(raw.reading);
  return readings;
}

void drop_blank_rows(RawLog& raw, std::vector<Finding>& health) {
  constexpr std::size_t several = 3;
  std::vector<std::size_t> written;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    std::size_t zeros = 0, others = 0;
    for (std::size_t c = 0; c < channels; ++c) {
      zeros += raw.at(i, c) == 0.0;
      others += std::isfinite(raw.at(i, c)) && raw.at(i, c) != 0.0;
    }
    if (zeros < several || others > 0) written.push_back(i);
  }
  const std::size_t blank = raw.size() - written.size();
  // Half a log of zeros is a car that stands.
  if (blank == 0 || 2 * blank > raw.size()) return;
  raw = raw.picked(written);
  health.push_back({Finding::Level::note, "rows", std::to_string(blank) + " without any reading", "left out"});
}

void drop_gross_outliers(RawLog& raw, std::vector<Finding>& health) {
  drop_impossible_commands(raw, health);
  std::vector<std::size_t> count;
  const std::size_t readings = drop_far_readings(raw, count);
  // Three wrong readings of six: the row is dropped, but for its commands where they are continuous.
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (count[i] >= 3) {
      for (std::size_t c = 0; c < channels; ++c) raw.at(i, c) = not_a_number;
      if (command_jumps(raw.d, i, 0.02) || command_jumps(raw.delta, i, 0.004)) continue;
    }
    kept.push_back(i);
  }
  const std::size_t rows = raw.size() - kept.size();
  if (rows > 0) {
    raw = raw.picked(kept);
    health.push_back({rows * 20 > raw.size() ? Finding::Level::bad : Finding::Level::note, "outliers",
                      std::to_string(rows) + " rows far off all around them", "left out"});
  }
  if (readings > 0)
    health.push_back({readings * 20 > raw.size() * channels ? Finding::Level::bad : Finding::Level::note, "outliers",
                      std::to_string(readings) + " readings far off all around them", "left out"});
}

void unwrap_yaw(RawLog& raw, std::vector<Finding>& health) {
  const std::size_t jumps = unwrap_angles(raw.reading, Channel::yaw, channels);
  if (jumps > 0)
    health.push_back({Finding::Level::note, "yaw", "wrapped " + std::to_string(jumps) + " times", "made continuous"});
}

std::size_t drop_outliers(RawLog& raw) {
  std::size_t dropped = 0;
  for (std::size_t c = 0; c < channels; ++c) {
    std::vector<double> off(raw.size(), 0.0), size;
    for (std::size_t i = 2; i + 2 < raw.size(); ++i) {
      off[i] = off_cubic(raw, i, c);
      if (std::isfinite(off[i])) size.push_back(std::abs(off[i]));
    }
    // At least 0.3 % of the root mean square change over 25 rows, so that rounding is no outlier.
    double change = 0.0, count = 1e-9;
    for (std::size_t i = 25; i < raw.size(); ++i) {
      const double step = raw.at(i, c) - raw.at(i - 25, c);
      if (!std::isfinite(step)) continue;
      change += step * step;
      count += 1.0;
    }
    const double scale = std::max(1.4826 * upper_median(size, 0.0), 0.003 * std::sqrt(change / count));
    if (!(scale > 0.0)) continue;
    for (std::size_t i = 2; i + 2 < raw.size(); ++i) {
      // A spike of size s leaves -2/3 s in the residuals beside it; a quick motion does not.
      const auto beside = [&](std::size_t j) { return std::abs(off[j] / off[i] + 2.0 / 3.0) < 0.35; };
      if (!(std::abs(off[i]) > 7.0 * scale) || !beside(i - 1) || !beside(i + 1)) continue;
      raw.at(i, c) = not_a_number;
      ++dropped;
    }
  }
  return dropped;
}

std::size_t drop_place_spikes(Session& session) {
  std::size_t dropped = 0;
  for (std::size_t c = 0; c < Channel::yaw; ++c) {
    const RawLog read = readings_of(session, c);
    RawLog without = read;
    if (drop_outliers(without) == 0) continue;
    const double least = 2.0 * ordinary_step(read, c);  // less is a reading that was written a row late
    for (std::size_t i = 3; i + 3 < read.size(); ++i) {
      if (!std::isnan(without.at(i, c)) || !is_single_jump(read, i, c, least)) continue;
      session.reading[read.row[i] * channels + c] = not_a_number;
      ++dropped;
    }
  }
  return dropped;
}

}  // namespace gripline::measured
