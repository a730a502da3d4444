#include "measured/session/session.hpp"

#include <algorithm>
#include <cmath>

#include "measured/readings/bridged_readings.hpp"
#include "measured/readings/reading_pace.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {

std::size_t Session::row_before(double time) const {
  const auto above = std::upper_bound(t.begin(), t.end(), time);
  return above == t.begin() ? rows() : static_cast<std::size_t>(above - t.begin()) - 1;
}

double Session::interpolate(std::size_t channel, double time, double longest_gap) const {
  return interpolate_from(row_before(time + 1e-9), channel, time, longest_gap);
}

double Session::interpolate_from(std::size_t i, std::size_t channel, double time, double longest_gap) const {
  if (i >= rows()) return not_a_number;
  const double here = at(i, channel);
  if (time <= t[i] + 1e-9) return here;
  if (i + 1 >= rows() || is_longer(t[i + 1] - t[i], longest_gap)) return not_a_number;
  return here + (at(i + 1, channel) - here) * (time - t[i]) / (t[i + 1] - t[i]);
}

BridgedReading Session::bridge(std::size_t channel, double time, double until, double longest_gap) const {
  std::size_t i = row_before(time + 1e-9);
  if (i >= rows()) return {};
  std::size_t next = i + 1;
  while (i > 0 && std::isnan(at(i, channel)) && !is_longer(time - t[i - 1], longest_gap)) --i;
  const double last = at(i, channel);
  if (std::isnan(last) || is_longer(time - t[i], longest_gap)) return {};
  if (time <= t[i] + 1e-9) return {last};
  while (next < rows() && t[next] <= until + 1e-9 && std::isnan(at(next, channel))) ++next;
  if (next >= rows() || t[next] > until + 1e-9) return {last};
  if (is_longer(t[next] - t[i], longest_gap)) return {};
  const double change = (at(next, channel) - last) / (t[next] - t[i]);
  return {last + change * (time - t[i]), change};
}

namespace {

/// Mean of a held command over the grid's step around `time`, so that commands that are linear between samples have the
/// mean of what is held over every stretch. `row` is the one at or before `time`; it moves on to the last that counts.
double mean_of_held(const Session& session, double CommandSample<double>::*command, double time, double dt,
                    std::size_t& row) {
  const double from = time - 0.5 * dt, to = time + 0.5 * dt;
  while (row > 0 && session.t[row] > from) --row;
  double sum = 0.0;
  for (double begin = from;; ++row) {
    const bool last = row + 1 >= session.rows() || session.t[row + 1] > to - 1e-9;
    const double end = last ? to : session.t[row + 1];
    sum += (end - begin) * session.command[row].*command;
    begin = end;
    if (last) return sum / dt;
  }
}

}  // namespace

CommandGrid::CommandGrid(const Session& session, double spacing) : t0(session.t.front()), dt(spacing) {
  const auto n = static_cast<std::size_t>((session.t.back() - t0) / dt + 1e-6) + 1;
  sample.reserve(n);
  row_at.reserve(n);
  std::size_t i = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const double time = t0 + static_cast<double>(k) * dt;
    while (i + 1 < session.rows() && session.t[i + 1] <= time + 1e-9) ++i;
    const CommandSample<double>& a = session.command[i];
    const bool on_row = time <= session.t[i] + 1e-9 || i + 1 >= session.rows();
    const bool stays = on_row || is_longer(session.t[i + 1] - session.t[i], even_motion);
    const CommandSample<double>& b = stays ? a : session.command[i + 1];
    const double share = stays ? 0.0 : (time - session.t[i]) / (session.t[i + 1] - session.t[i]);
    std::size_t latest = i;
    const auto value = [&](double CommandSample<double>::*command, bool held) {
      std::size_t row = i;
      const double v =
          held ? mean_of_held(session, command, time, dt, row) : a.*command + share * (b.*command - a.*command);
      latest = std::max(latest, held || stays ? row : i + 1);
      return v;
    };
    const double d = value(&CommandSample<double>::d, session.throttle_between.held());
    const double delta = value(&CommandSample<double>::delta, session.steering_between.held());
    sample.push_back({d, delta});
    row_at.push_back(session.t[latest]);
  }
  known_at = row_at;
  fixed_at = {row_at, row_at};
  ramp(session, &CommandSample<double>::d, session.throttle_between.every, fixed_at[0]);
  ramp(session, &CommandSample<double>::delta, session.steering_between.every, fixed_at[1]);
  for (const CommandSample<double>& c : sample) dual.push_back({Dual8(c.d), Dual8(c.delta)});
}

void CommandGrid::ramp(const Session& session, double CommandSample<double>::*command, double every,
                       std::vector<double>& fixed) {
  if (!(every > 0.0)) return;
  ReadingPace pace(every, t0);
  for (std::size_t i = 1; i < session.rows(); ++i) {
    const double from = session.command[i - 1].*command, to = session.command[i].*command, end = session.t[i];
    if (from == to) continue;
    const double begin = std::max(end - every, pace.last());
    pace.change(end);
    if (!pace.kept()) continue;
    for (auto k = static_cast<std::size_t>(std::max(0.0, std::ceil((begin - t0) / dt)));
         k < sample.size() && t0 + static_cast<double>(k) * dt < end - 1e-9; ++k) {
      sample[k].*command = from + (to - from) * (t0 + static_cast<double>(k) * dt - begin) / (end - begin);
      fixed[k] = std::max(fixed[k], end);
      known_at[k] = std::max(known_at[k], end);
    }
  }
}

namespace {

std::size_t count_until(const std::vector<double>& times, double time) {
  return static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time + 1e-9) - times.begin());
}

}  // namespace

std::size_t CommandGrid::known(double time) const { return count_until(known_at, time); }

std::size_t CommandGrid::shown_by(double time) const { return count_until(row_at, time); }

template <class T>
void CommandGrid::copy_shown(double time, const CommandSample<double>& now, std::size_t first,
                             std::vector<CommandSample<T>>& to) const {
  const std::size_t n = std::max<std::size_t>(1, shown_by(time));
  to.clear();
  for (std::size_t k = std::min(first, n - 1); k < n; ++k) {
    const CommandSample<T>& moving = data<T>()[k];
    const auto is_fixed = [&](std::size_t command) { return fixed_at[command][k] <= time + 1e-9; };
    to.push_back({is_fixed(0) ? moving.d : T(now.d), is_fixed(1) ? moving.delta : T(now.delta)});
  }
}

template void CommandGrid::copy_shown(double, const CommandSample<double>&, std::size_t,
                                      std::vector<CommandSample<double>>&) const;
template void CommandGrid::copy_shown(double, const CommandSample<double>&, std::size_t,
                                      std::vector<CommandSample<Dual8>>&) const;

}  // namespace gripline::measured
