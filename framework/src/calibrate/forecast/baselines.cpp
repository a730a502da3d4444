#include "calibrate/forecast/baselines.hpp"

#include <algorithm>
#include <cmath>

namespace gripline::calibrate {
namespace {

/// Mean curvature of a rolling car over the commands between two times.
double rolling_curvature(const Session& s, double from, double to, double wheelbase) {
  double sum = 0.0, count = 0.0;
  const auto first = std::lower_bound(s.t.begin(), s.t.end(), from - 1e-9);
  for (auto t = first; t != s.t.end() && *t <= to + 1e-9; ++t, count += 1.0)
    sum += std::tan(std::clamp(s.command[static_cast<std::size_t>(t - s.t.begin())].delta, -1.4, 1.4)) / wheelbase;
  return count > 0.0 ? sum / count : 0.0;
}

double steering_at(const Session& s, double time) {
  const std::size_t row = std::min(s.row_before(time + 1e-9), s.rows() - 1);
  return std::clamp(s.command[row].delta, -1.4, 1.4);
}

/// The last row before a time, and at most `oldest` [s] before it, that has a channel; rows() where none has.
std::size_t last_with(const Session& s, std::size_t channel, double time, double oldest) {
  std::size_t end = s.row_before(time + 1e-9);
  end = end < s.rows() ? end + 1 : 0;
  for (std::size_t i = end; i > 0 && time - s.t[i - 1] <= oldest; --i)
    if (!std::isnan(s.at(i - 1, channel))) return i - 1;
  return s.rows();
}

/// Where the car is at a start and how it moves. Channels may be read in different rows: one that the start's row lacks
/// is the last that was read shortly before, and of the pose what the velocities make of it until the start.
std::array<double, channels> state_at(const Session& s, double start) {
  constexpr double oldest = 0.25;  // [s]
  using measured::Channel;
  std::array<double, channels> now{}, age{};
  for (std::size_t c = 0; c < channels; ++c) {
    now[c] = s.interpolate(c, start);
    if (!std::isnan(now[c])) continue;
    const std::size_t row = last_with(s, c, start, oldest);
    if (row < s.rows()) now[c] = s.at(row, c), age[c] = start - s.t[row];
  }
  const double vy = std::isnan(now[Channel::vy]) ? 0.0 : now[Channel::vy];
  if (age[Channel::yaw] > 0.0 && s.has[Channel::yaw_rate])
    now[Channel::yaw] += age[Channel::yaw] * now[Channel::yaw_rate];
  const double c = std::cos(now[Channel::yaw]), sn = std::sin(now[Channel::yaw]);
  if (age[Channel::x] > 0.0) now[Channel::x] += age[Channel::x] * (now[Channel::vx] * c - vy * sn);
  if (age[Channel::y] > 0.0) now[Channel::y] += age[Channel::y] * (now[Channel::vx] * sn + vy * c);
  return now;
}

}  // namespace

std::vector<double> baseline(Baseline which, const Session& s, const Starts& starts, double wheelbase) {
  using measured::Channel;
  std::vector<double> out;
  for (const double start : starts.time) {
    const std::array<double, channels> now = state_at(s, start);
    const double vy = std::isnan(now[Channel::vy]) ? 0.0 : now[Channel::vy];
    // A log without a turn rate shows none; one that lacks it here leaves open how the car turns.
    const double turn_rate =
        std::isnan(now[Channel::yaw_rate]) && !s.has[Channel::yaw_rate] ? 0.0 : now[Channel::yaw_rate];
    for (const double h : starts.horizons) {
      double curvature_rate = turn_rate, side = vy, rate = now[Channel::yaw_rate];
      if (which == Baseline::constant_speed) curvature_rate = side = rate = 0.0;
      if (which == Baseline::kinematic) {
        curvature_rate = now[Channel::vx] * rolling_curvature(s, start, start + h, wheelbase);
        rate = now[Channel::vx] * std::tan(steering_at(s, start + h)) / wheelbase;
        side = 0.0;
      }
      // Constant velocities and turn rate: along a circle.
      const double turn = curvature_rate * h;
      const double along = std::abs(turn) > 1e-6 ? std::sin(turn) / turn : 1.0;
      const double across = std::abs(turn) > 1e-6 ? (1.0 - std::cos(turn)) / turn : 0.5 * turn;
      const double ahead = h * (now[Channel::vx] * along - side * across),
                   left = h * (now[Channel::vx] * across + side * along);
      out.push_back(now[Channel::x] + ahead * std::cos(now[Channel::yaw]) - left * std::sin(now[Channel::yaw]));
      out.push_back(now[Channel::y] + ahead * std::sin(now[Channel::yaw]) + left * std::cos(now[Channel::yaw]));
      out.push_back(now[Channel::yaw] + turn);
      out.push_back(now[Channel::vx]);
      out.push_back(std::isnan(now[Channel::vy]) ? now[Channel::vy] : side);
      out.push_back(std::isnan(now[Channel::yaw_rate]) ? now[Channel::yaw_rate] : rate);
    }
  }
  return out;
}

}  // namespace gripline::calibrate
