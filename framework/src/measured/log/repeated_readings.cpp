#include "measured/log/repeated_readings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "measured/readings/held_readings.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

/// Consecutive readings of a channel that are the same, by their rows; rows between them may have none.
struct Run {
  std::size_t first = 0, last = 0, count = 0;
};

std::vector<Run> runs_of(const RawLog& raw, std::size_t c) {
  std::vector<Run> runs;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (std::isnan(raw.at(i, c))) continue;
    if (runs.empty() || raw.at(i, c) != raw.at(runs.back().first, c)) runs.push_back({i, i, 0});
    runs.back().last = i;
    ++runs.back().count;
  }
  return runs;
}

/// Where the car moves, and how far it is, by the last speed that was read.
struct Motion {
  std::vector<bool> moves;
  std::vector<double> way;  // [m]
  /// Throughout these rows.
  bool during(std::size_t first, std::size_t last) const {
    return std::all_of(moves.begin() + static_cast<std::ptrdiff_t>(first),
                       moves.begin() + static_cast<std::ptrdiff_t>(last) + 1, [](bool m) { return m; });
  }
};

Motion motion_of(const RawLog& raw, double slowest) {
  Motion motion;
  double speed = 0.0, way = 0.0;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (i > 0) way += std::abs(speed) * (raw.t[i] - raw.t[i - 1]);
    if (const double read = raw.at(i, Channel::vx); !std::isnan(read)) speed = read;
    motion.moves.push_back(speed >= slowest);
    motion.way.push_back(way);
  }
  return motion;
}

/// The step of which nearly all differences of values next to each other are multiples, so that a few wild readings do
/// not hide it; 0 where there is none.
double resolution(std::vector<double> values) {
  constexpr double nearly_all = 0.9, off_step = 0.1;  // of the differences; of a step
  std::ranges::sort(values);
  const double same = 1e-9 * (lower_quantile(values, 0.9, 0.0) - lower_quantile(values, 0.1, 0.0));
  std::vector<double> gaps;
  for (std::size_t i = 1; i < values.size(); ++i)
    if (const double gap = values[i] - values[i - 1]; gap > same) gaps.push_back(gap);
  const double step = lower_quantile(gaps, 0.1, 0.0);
  const auto even = std::ranges::count_if(
      gaps, [step](double gap) { return std::abs(gap / step - std::round(gap / step)) < off_step; });
  return static_cast<double>(even) >= nearly_all * static_cast<double>(gaps.size()) ? step : 0.0;
}

/// How a channel goes from value to value.
struct Changes {
  double typical = 0.0, large = 0.0;  // size of a change: median, and what one in twenty exceeds
  double seldom_longer = 0.0;         // for how long one value stays in motion, but for one in twenty [s]
  bool fine = false;                  // they are larger than the resolution, as of no channel that is rounded coarsely
  bool noise = false;                 // they go to and fro, as noise does and no motion
};

/// Nothing of channels with hardly any change.
std::optional<Changes> changes_of(const RawLog& raw, std::size_t c, const std::vector<Run>& runs,
                                  const Motion& motion) {
  constexpr std::size_t few = 20;
  constexpr double much = 3.0;  // of the resolution
  if (runs.size() < few) return std::nullopt;
  std::vector<double> values, sizes, stays;
  double to_and_fro = 0.0, before = 0.0;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    values.push_back(raw.at(runs[k].first, c));
    if (k == 0) continue;
    const double change = difference_of(c, values[k], values[k - 1]);
    sizes.push_back(std::abs(change));
    to_and_fro += change * before;
    before = change;
    if (motion.moves[runs[k - 1].first] && motion.moves[runs[k - 1].last])
      stays.push_back(raw.t[runs[k].first] - raw.t[runs[k - 1].first]);
  }
  Changes changes;
  changes.typical = lower_quantile(sizes, 0.5, 0.0);
  changes.large = lower_quantile(sizes, 0.95, 0.0);
  changes.seldom_longer = lower_quantile(stays, 0.95, 0.0);
  changes.fine = changes.typical > much * resolution(std::move(values));
  changes.noise = to_and_fro < 0.0;
  return changes;
}

using AllRuns = std::array<std::vector<Run>, channels>;
using AllChanges = std::array<std::optional<Changes>, channels>;

/// Whether neither coordinate of the place changes in these rows, though the car goes on.
bool place_stands(const RawLog& raw, const Run& run, const AllChanges& changes, const Motion& motion) {
  constexpr double far = 5.0;  // typical changes of a coordinate
  for (const std::size_t c : {Channel::x, Channel::y}) {
    double value = not_a_number;
    for (std::size_t i = run.first; i <= run.last; ++i) {
      if (std::isnan(raw.at(i, c))) continue;
      if (!std::isnan(value) && raw.at(i, c) != value) return false;
      value = raw.at(i, c);
    }
    if (std::isnan(value)) return false;
  }
  double typical = 0.0;
  for (const std::size_t c : {Channel::x, Channel::y})
    if (changes[c]) typical = std::max(typical, changes[c]->typical);
  return motion.way[run.last] - motion.way[run.first] > far * typical;
}

/// Whether the k-th value of a channel stays too long to have been read again and again.
bool stands(const RawLog& raw, std::size_t c, std::size_t k, const AllRuns& runs, const AllChanges& changes,
            const Motion& motion) {
  constexpr double longest = 0.5, longer = 5.0;  // [s]; of what is seldom exceeded
  constexpr double jump = 4.0;                   // of a large change
  const Run& run = runs[c][k];
  const Changes& usual = *changes[c];
  if (raw.t[run.last] - raw.t[run.first] < std::max(longest, longer * usual.seldom_longer)) return false;
  if (!motion.during(run.first, run.last)) return false;
  if (usual.fine && usual.noise) return true;
  if (c < Channel::yaw && place_stands(raw, run, changes, motion)) return true;
  if (k + 1 == runs[c].size()) return false;
  const double left_by = difference_of(c, raw.at(runs[c][k + 1].first, c), raw.at(run.first, c));
  return std::abs(left_by) > jump * usual.large;
}

std::string listed(const std::vector<std::size_t>& which) {
  std::string names;
  for (const std::size_t c : which) names += (names.empty() ? "" : ", ") + std::string(channel_info[c].name);
  return names;
}

/// Times of a log in full: it may count from 1970.
std::string seconds(double t) { return significant(t, 13) + " s"; }

/// Rows without readings whose commands stand as well: the logger itself stood.
void drop_rows_of_standing_commands(RawLog& raw, std::size_t first, std::size_t last, std::vector<bool>& drop) {
  for (std::size_t i = first + 1; i <= last; ++i)
    if (raw.d[i] != raw.d[first] || raw.delta[i] != raw.delta[first]) return;
  for (std::size_t i = first + 1; i <= last; ++i) {
    bool empty = true;
    for (std::size_t c = 0; c < channels; ++c) empty = empty && std::isnan(raw.at(i, c));
    if (empty) drop[i] = true;
  }
}

}  // namespace

void leave_out_constant_lateral_speed(RawLog& raw, std::vector<Finding>& health) {
  constexpr double turning = 0.05;  // [rad/s]
  constexpr std::size_t few = 20;
  const std::vector<Run> runs = runs_of(raw, Channel::vy);
  if (runs.size() != 1 || runs.front().count < few) return;
  std::vector<double> rates;
  for (std::size_t i = 0; i < raw.size(); ++i)
    if (const double rate = raw.at(i, Channel::yaw_rate); !std::isnan(rate)) rates.push_back(std::abs(rate));
  if (!(lower_quantile(std::move(rates), 0.9, 0.0) > turning)) return;
  health.push_back({Finding::Level::bad, "vy",
                    "is " + significant(raw.at(runs.front().first, Channel::vy)) +
                        " in every row, though the car turns: it was not measured",
                    "left out; leave the column empty, or out"});
  for (std::size_t i = 0; i < raw.size(); ++i) raw.at(i, Channel::vy) = not_a_number;
}

void leave_out_standing(RawLog& raw, double slowest, std::vector<Finding>& health) {
  const Motion motion = motion_of(raw, slowest);
  AllRuns runs;
  AllChanges changes;
  for (std::size_t c = 0; c < channels; ++c) {
    runs[c] = runs_of(raw, c);
    changes[c] = changes_of(raw, c, runs[c], motion);
  }
  std::map<std::pair<std::size_t, std::size_t>, std::vector<std::size_t>> standing;  // channels by first and last row
  for (std::size_t c = 0; c < channels; ++c)
    for (std::size_t k = 0; changes[c] && k < runs[c].size(); ++k)
      if (stands(raw, c, k, runs, changes, motion)) standing[{runs[c][k].first, runs[c][k].last}].push_back(c);
  if (standing.empty()) return;

  std::map<std::vector<std::size_t>, std::vector<Run>> of_channels;
  for (const auto& [rows, which] : standing) {
    of_channels[which].push_back({rows.first, rows.second, 0});
    for (const std::size_t c : which)
      for (std::size_t i = rows.first + 1; i <= rows.second; ++i) raw.at(i, c) = not_a_number;
  }
  for (const auto& [which, times] : of_channels) {
    double longest = 0.0;
    for (const Run& one : times) longest = std::max(longest, raw.t[one.last] - raw.t[one.first]);
    const std::string first = "from " + seconds(raw.t[times[0].first]) + " to " + seconds(raw.t[times[0].last]);
    const std::string many = std::to_string(times.size()) + " times for up to " + significant(longest) + " s, first ";
    health.push_back({Finding::Level::note, listed(which),
                      std::string(which.size() > 1 ? "stand" : "stands") + " still " +
                          (times.size() > 1 ? many + first : first) + " while the car moves",
                      "left out"});
  }
  std::vector<bool> drop(raw.size(), false);
  for (const auto& [rows, which] : standing) drop_rows_of_standing_commands(raw, rows.first, rows.second, drop);
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < raw.size(); ++i)
    if (!drop[i]) kept.push_back(i);
  if (kept.size() == raw.size()) return;
  health.push_back({Finding::Level::note, "rows",
                    std::to_string(raw.size() - kept.size()) + " in which commands and all readings stand still",
                    "left out"});
  raw = raw.picked(kept);
}

namespace {

/// Rows from one new value of a channel to the next, where they come at a steady pace; 0 where they do not.
double pace_of(const RawLog& raw, std::size_t c, double dt, const Motion& motion) {
  constexpr double longest = 2.0;       // [s]
  constexpr std::size_t few = 20;       // changes
  constexpr double exact = 0.3;         // of a row
  constexpr double all_but_few = 0.97;  // of the changes, where they keep to every so many rows exactly
  constexpr double most = 0.9;          // of the changes, where a clock of its own or lost rows move them
  const std::vector<Run> runs = runs_of(raw, c);
  const std::optional<Changes> changes = changes_of(raw, c, runs, motion);
  if (!changes) return 0.0;
  std::vector<double> rows;
  double repeats = 0.0;
  for (std::size_t k = 0; k + 1 < runs.size(); ++k) {
    const double stayed = raw.t[runs[k + 1].first] - raw.t[runs[k].first];
    if (stayed > longest || !motion.during(runs[k].first, runs[k + 1].first)) continue;
    rows.push_back(stayed / dt);
    repeats += static_cast<double>(runs[k].count - 1);
  }
  const double count = static_cast<double>(rows.size());
  const double shortest = lower_quantile(rows, 0.1, 0.0), whole = std::round(shortest);
  // Readings with empty cells between them come at a pace, but do not repeat.
  if (rows.size() < few || whole < 2.0 || shortest < whole - exact || repeats < 0.5 * count) return 0.0;
  const auto share = [&](auto&& holds) { return static_cast<double>(std::ranges::count_if(rows, holds)) / count; };
  if (share([&](double n) { return std::abs(n - whole * std::round(n / whole)) < exact; }) >= all_but_few) return whole;
  double sum = 0.0, near = 0.0;
  for (const double n : rows)
    if (n < 1.5 * whole + exact) sum += n, near += 1.0;
  const double pace = sum / near, off = std::max(0.6, 0.45 * pace);
  const bool steady = share([&](double n) { return std::abs(n - pace) <= off; }) >= most;
  return steady && changes->fine ? pace : 0.0;
}

}  // namespace

void leave_out_repeats(RawLog& raw, double dt, double slowest, std::vector<Finding>& health) {
  const Motion motion = motion_of(raw, slowest);
  std::map<std::string, std::vector<std::size_t>> of_pace;
  for (std::size_t c = 0; c < channels; ++c)
    if (const double pace = pace_of(raw, c, dt, motion); pace > 0.0) of_pace[significant(pace)].push_back(c);
  for (const auto& [pace, which] : of_pace) {
    for (const std::size_t c : which) {
      std::vector<double> values;
      for (std::size_t i = 0; i < raw.size(); ++i) values.push_back(raw.at(i, c));
      drop_held(raw.t, values);
      for (std::size_t i = 0; i < raw.size(); ++i) raw.at(i, c) = values[i];
    }
    health.push_back(
        {Finding::Level::note, listed(which), "a new value every " + pace + " rows", "repeats are left out"});
  }
}

}  // namespace gripline::measured
