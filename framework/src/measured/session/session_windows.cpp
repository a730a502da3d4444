#include "measured/session/session_windows.hpp"

#include <algorithm>
#include <numbers>

#include "measured/readings/bridged_readings.hpp"
#include "measured/readings/held_readings.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

using std::numbers::pi;

constexpr double window_length = 0.5;  // [s]

double mean_of(const Session& s, std::size_t first, std::size_t last, std::size_t channel) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = first; i <= last; ++i)
    if (!std::isnan(s.at(i, channel))) sum += s.at(i, channel), ++count;
  return 2 * count > last - first ? sum / static_cast<double>(count) : NAN;
}

/// A place that is repeated until there is a new one would show a car that stands and jumps.
void blank_held_places(Session& s) {
  std::vector<double> places;  // numbers that change where x or y do
  for (std::size_t i = 0; i < s.rows(); ++i) places.push_back(s.at(i, Channel::x) + pi * s.at(i, Channel::y));
  if (!(rows_between_new(s.t, places) > 1.0)) return;
  for (std::size_t i = s.rows(); i-- > 1;)
    if (places[i] == places[i - 1])
      s.reading[i * channels + Channel::x] = s.reading[i * channels + Channel::y] = not_a_number;
}

/// The median time from one place to the next [s].
double time_between_places(const Session& s) {
  std::vector<double> between;
  double last = NAN;
  for (std::size_t i = 0; i < s.rows(); ++i) {
    if (!std::isfinite(s.at(i, Channel::x) + s.at(i, Channel::y))) continue;
    if (!std::isnan(last)) between.push_back(s.t[i] - last);
    last = s.t[i];
  }
  return median(std::move(between), 0.0);
}

/// Of a session without places that are repeated. Bridged, as channels that are read in few of the rows would hardly be
/// seen at both ends of a window.
std::vector<SessionWindow> windows_of_bridged(Session s, double longest_bridged) {
  s.reading = bridged_readings(s.t, std::move(s.reading), longest_bridged);
  std::vector<SessionWindow> windows;
  std::size_t j = 0;
  for (std::size_t i = 0; i < s.rows(); i = std::max(i + 1, (i + j) / 2)) {
    j = i;
    while (j + 1 < s.rows() && s.t[j] - s.t[i] < window_length) ++j;
    SessionWindow w;
    w.begin = s.t[i];
    w.seconds = s.t[j] - s.t[i];
    if (w.seconds < window_length) break;
    if (w.seconds > 2.0 * window_length) continue;
    const double dx = s.at(j, Channel::x) - s.at(i, Channel::x), dy = s.at(j, Channel::y) - s.at(i, Channel::y);
    w.way = std::hypot(dx, dy);
    w.course = std::atan2(dy, dx);
    w.turn = s.at(j, Channel::yaw) - s.at(i, Channel::yaw);
    w.heading = 0.5 * (s.at(j, Channel::yaw) + s.at(i, Channel::yaw));
    w.yaw = mean_of(s, i, j, Channel::yaw);
    w.speed = mean_of(s, i, j, Channel::vx);
    w.side = mean_of(s, i, j, Channel::vy);
    w.rate = mean_of(s, i, j, Channel::yaw_rate);
    w.gain = s.at(j, Channel::vx) - s.at(i, Channel::vx);
    double steer = 0.0, throttle = 0.0;
    for (std::size_t k = i; k <= j; ++k) steer += s.command[k].delta, throttle += s.command[k].d;
    w.steer = steer / static_cast<double>(j - i + 1);
    w.throttle = throttle / static_cast<double>(j - i + 1);
    windows.push_back(w);
  }
  return windows;
}

}  // namespace

std::vector<SessionWindow> session_windows(Session s) {
  constexpr double longest = 2.5;  // [s]
  blank_held_places(s);
  const double bridged = std::clamp(1.5 * time_between_places(s), window_length, longest);
  return windows_of_bridged(std::move(s), bridged);
}

std::vector<SessionWindow> session_windows(Session s, double longest_bridged) {
  blank_held_places(s);
  return windows_of_bridged(std::move(s), longest_bridged);
}

std::vector<bool> moving_rows(const Session& session) {
  const std::vector<SessionWindow> windows = session_windows(session);
  std::vector<double> speeds;
  for (const SessionWindow& w : windows)
    if (std::isfinite(speed_of(w))) speeds.push_back(std::abs(speed_of(w)));
  const double slowest = slowest_driving(top_speed(std::move(speeds)));
  const auto moves = [&](const SessionWindow& w) { return std::abs(speed_of(w)) > slowest; };
  const bool none = std::ranges::none_of(windows, moves);
  std::vector<bool> moving(session.rows(), none);
  for (const SessionWindow& w : windows)
    for (std::size_t i = session.row_before(w.begin);
         moves(w) && i < session.rows() && session.t[i] <= w.begin + w.seconds + 1e-9; ++i)
      moving[i] = true;
  return moving;
}

Session while_moving(Session s) {
  const std::vector<bool> moving = moving_rows(s);
  for (std::size_t i = 0; i < s.rows(); ++i)
    if (!moving[i]) std::fill_n(s.reading.begin() + static_cast<std::ptrdiff_t>(i * channels), channels, not_a_number);
  return s;
}

double typical_speed(const Session& session) {
  const std::vector<bool> moving = moving_rows(session);
  std::vector<double> speeds;
  for (std::size_t i = 1; i < session.rows(); ++i) {
    if (!moving[i]) continue;
    double v = session.at(i, Channel::vx);
    if (std::isnan(v))
      v = std::hypot(session.at(i, Channel::x) - session.at(i - 1, Channel::x),
                     session.at(i, Channel::y) - session.at(i - 1, Channel::y)) /
          (session.t[i] - session.t[i - 1]);
    if (std::isfinite(v)) speeds.push_back(std::abs(v));
  }
  if (speeds.empty()) return 1.0;
  return std::max(lower_quantile(std::move(speeds), 0.75), standing_speed);
}

double speed_over_path(const std::vector<SessionWindow>& windows) {
  return median_ratio(
      windows, [](const SessionWindow& w) { return w.speed; }, [](const SessionWindow& w) { return w.way / w.seconds; },
      least_of_ratio);
}

double side_over_path(const std::vector<SessionWindow>& windows) {
  return median_ratio(
      windows, [](const SessionWindow& w) { return w.side; }, [](const SessionWindow& w) { return w.way / w.seconds; },
      least_of_ratio);
}

Correlation turning_correlation(const std::vector<SessionWindow>& windows, double slowest) {
  Correlation all;
  for (const SessionWindow& w : windows) {
    const double rate = std::isnan(w.rate) ? w.turn / w.seconds : w.rate, v = speed_of(w);
    if (v > slowest && std::isfinite(rate)) all.add(w.steer, rate / v);
  }
  return all;
}

}  // namespace gripline::measured
