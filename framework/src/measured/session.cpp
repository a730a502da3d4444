#include "measured/session.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "measured/reading_pace.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {

std::size_t Session::row_before(double time) const {
  const auto above = std::upper_bound(t.begin(), t.end(), time);
  return above == t.begin() ? rows() : static_cast<std::size_t>(above - t.begin()) - 1;
}

double Session::interpolate(std::size_t channel, double time, double longest_gap) const {
  const std::size_t i = row_before(time + 1e-9);
  if (i >= rows()) return not_a_number;
  const double here = at(i, channel);
  if (time <= t[i] + 1e-9) return here;
  if (i + 1 >= rows() || t[i + 1] - t[i] > longest_gap) return not_a_number;
  return here + (at(i + 1, channel) - here) * (time - t[i]) / (t[i + 1] - t[i]);
}

CommandGrid::CommandGrid(const Session& session, double spacing) : t0(session.t.front()), dt(spacing) {
  constexpr double longest_gap = 0.25;  // [s] bridged by a straight line
  const auto n = static_cast<std::size_t>((session.t.back() - t0) / dt + 1e-6) + 1;
  sample.reserve(n);
  known_at.reserve(n);
  std::size_t i = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const double time = t0 + static_cast<double>(k) * dt;
    while (i + 1 < session.rows() && session.t[i + 1] <= time + 1e-9) ++i;
    const CommandSample<double>& a = session.command[i];
    const bool on_row = time <= session.t[i] + 1e-9 || i + 1 >= session.rows();
    const bool held = session.held_throttle && session.held_steering;
    if (on_row || held || session.t[i + 1] - session.t[i] > longest_gap) {
      sample.push_back(a);
      known_at.push_back(session.t[i]);
      continue;
    }
    const CommandSample<double>& b = session.command[i + 1];
    const double share = (time - session.t[i]) / (session.t[i + 1] - session.t[i]);
    const double d = session.held_throttle ? a.d : a.d + share * (b.d - a.d);
    const double delta = session.held_steering ? a.delta : a.delta + share * (b.delta - a.delta);
    sample.push_back({d, delta});
    known_at.push_back(session.t[i + 1]);
  }
  ramp(session, &CommandSample<double>::d, session.throttle_every);
  ramp(session, &CommandSample<double>::delta, session.steering_every);
  for (const CommandSample<double>& c : sample) dual.push_back({Dual8(c.d), Dual8(c.delta)});
}

void CommandGrid::ramp(const Session& session, double CommandSample<double>::*command, double every) {
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
      known_at[k] = std::max(known_at[k], end);
    }
  }
}

std::size_t CommandGrid::known(double time) const {
  return static_cast<std::size_t>(std::upper_bound(known_at.begin(), known_at.end(), time + 1e-9) - known_at.begin());
}

}  // namespace gripline::measured
