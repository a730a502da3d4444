#include "measured/log/log_checks.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "geometry/plane.hpp"
#include "measured/readings/directions.hpp"
#include "measured/readings/unit_checks.hpp"
#include "measured/session/session_windows.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

/// Half seconds of a log that show all that is compared.
std::vector<SessionWindow> full_windows(const RawLog& raw) {
  constexpr double longest_bridged = 0.5;  // [s]: the way between two places is compared with the speed
  Session session;
  session.t = raw.t;
  session.reading = raw.reading;
  for (std::size_t i = 0; i < raw.size(); ++i) session.command.push_back({raw.d[i], raw.delta[i]});
  std::vector<SessionWindow> windows = session_windows(std::move(session), longest_bridged);
  std::erase_if(windows, [](const SessionWindow& w) { return !std::isfinite(w.way + w.turn + w.speed + w.rate); });
  return windows;
}

/// vx and, where it is read, vy over the speed of the place.
void check_speed(const CsvTable& table, double ratio, double side) {
  const std::string found = "vx_mps is " + significant(ratio) + " times the speed of x_m, y_m";
  if (velocities_look_swapped(ratio, side))
    refuse(table, found + ", and vy_mps " + significant(side) + " times: vx_mps and vy_mps look swapped");
  for (const WrongUnit& u : wrong_units)
    if (ratio > u.low && ratio < u.high)
      refuse(table, found + (u.of_place ? ": x_m, y_m look like " : ": vx_mps looks like ") + u.name +
                        (u.of_place ? "; expected m" : "; expected m/s"));
  if (!is_about(ratio)) refuse(table, found + "; expected about 1");
}

void check_rate(const CsvTable& table, double ratio) {
  if (is_of_degrees(ratio))
    refuse(table, "yaw_rate_radps is " + significant(ratio) +
                      " times the rate of yaw_rad: it looks like deg/s; expected rad/s");
  if (is_over_degrees(ratio))
    refuse(table, "yaw_rad turns " + significant(1.0 / ratio) +
                      " times as fast as yaw_rate_radps says: it looks like degrees; expected rad");
  if (has_other_sign(ratio))
    refuse(table,
           "yaw_rate_radps seems to have the other sign: it is negative where yaw_rad rises; expected both positive "
           "to the left (counter-clockwise)");
}

/// Course over ground and yaw agree to within the slip angle unless the frame is rotated or mirrored.
void check_frame(const CsvTable& table, const std::vector<SessionWindow>& windows) {
  std::vector<double> ways, off, mirrored;
  for (const SessionWindow& w : windows) ways.push_back(w.way);
  const double enough = 0.5 * upper_median(ways, 0.0);
  for (const SessionWindow& w : windows) {
    if (w.way < enough || std::abs(w.turn) > 1.5) continue;
    off.push_back(w.course - w.heading);
    mirrored.push_back(w.course + w.heading);
  }
  if (off.size() < 5) return;
  const std::complex<double> direct = mean_direction(off), mirror = mean_direction(mirrored);
  if (are_about_zero(direct)) return;
  if (are_alike(direct))
    refuse(table, "the car moves " + significant(std::arg(direct)) +
                      " rad to the left of where yaw_rad points; expected yaw counter-clockwise from the x axis");
  if (are_alike(mirror))
    refuse(table,
           std::string("yaw_rad turns the other way than the path of x_m, y_m: the frame seems to be left-handed") +
               (is_about_a_quarter(mirror) ? ", or x_m and y_m are swapped" : "") +
               "; expected y to the left of x and yaw counter-clockwise");
}

/// The car turns to the side it is steered to, but for moments of countersteer. Asked of windows driven forwards at
/// `slowest` [m/s] and more: a car that manoeuvres may have its wheels turned any way.
void check_steering(const CsvTable& table, std::vector<SessionWindow> windows, double slowest) {
  std::erase_if(windows, [&](const SessionWindow& w) { return w.speed < slowest; });
  std::vector<double> sizes;
  sizes.reserve(windows.size());
  for (const SessionWindow& w : windows) sizes.push_back(std::abs(w.steer));
  const double enough = std::max(1e-3, lower_quantile(sizes, 0.7, 0.0));
  double along = 0.0, all = 0.0;
  for (const SessionWindow& w : windows) {
    if (std::abs(w.steer) < enough) continue;
    all += 1.0;
    along += w.steer * w.turn > 0.0 ? 1.0 : 0.0;
  }
  if (all >= 8.0 && along < 0.15 * all)
    refuse(table, "the steering seems to have the other sign: the car turns right where delta_rad is positive in " +
                      std::to_string(std::lround(100.0 * (1.0 - along / all))) +
                      " % of the bends; expected positive to the left");
}

/// Angles of the wheels and pedals: in radians, of the wheels and not of the handwheel, no per cent.
void check_commands(const CsvTable& table, const RawLog& raw, double delta_max) {
  std::vector<double> angles, pedals;
  for (const double angle : raw.delta) angles.push_back(std::abs(angle));
  for (const double d : raw.d) pedals.push_back(std::abs(d));
  const double steered = lower_quantile(angles, often_steered, 0.0), pedal = lower_quantile(pedals, 0.97, 0.0);
  if (steered > most_steering)
    refuse(table, "delta_rad reaches " + significant(steered) + ": it looks like degrees; expected rad");
  if (is_of_handwheel(steered, delta_max))
    refuse(table, "delta_rad reaches " + significant(steered) + ", and the car's delta_max is " +
                      significant(delta_max) +
                      ": it looks like the angle of the handwheel; expected that of the road wheels, so divide by the "
                      "steering ratio");
  if (pedal > most_pedal)
    refuse(table, "d reaches " + significant(pedal) + ": it looks like per cent; expected -1 to 1");
}

}  // namespace

void check_yaw_is_radians(const CsvTable& table, const RawLog& raw) {
  constexpr double half_turn = std::numbers::pi, close = 0.5;  // [rad]
  std::size_t jumps = 0;
  for (std::size_t i = 1; i < raw.size(); ++i) {
    const double jump = raw.at(i, Channel::yaw) - raw.at(i - 1, Channel::yaw);
    const double turn = raw.at(i, Channel::yaw_rate) * (raw.t[i] - raw.t[i - 1]);
    // A car that circles wraps often, by a whole turn less what it turned; a rate in degrees tells nothing of that.
    const double off = wrap_angle(jump - (std::abs(turn) < half_turn ? turn : 0.0));
    if (std::abs(jump) > half_turn && std::abs(off) > close) ++jumps;
  }
  if (20 * jumps > raw.size())
    refuse(table, "yaw_rad jumps by more than half a turn in " + std::to_string(jumps) + " of " +
                      std::to_string(raw.size()) + " rows: it looks like degrees; expected rad");
}

/// A column that holds nothing would be blamed on what is made of it: a speed of 0, a car that is parked.
void check_empty(const CsvTable& table, const RawLog& raw) {
  for (const std::size_t c : {Channel::x, Channel::y, Channel::yaw, Channel::vx, Channel::yaw_rate}) {
    std::size_t rows = 0;
    for (std::size_t i = 0; i < raw.size(); ++i) rows += std::isfinite(raw.at(i, c)) ? 1 : 0;
    if (rows == 0) refuse(table, std::string(channel_info[c].column) + " holds no number; expected readings");
  }
}

void check_units(const CsvTable& table, const RawLog& raw, const LogExpectations& expected,
                 std::vector<Finding>& health) {
  constexpr std::size_t few = 8;  // windows; a log of five seconds has twice as many
  check_empty(table, raw);
  const std::vector<SessionWindow> windows = full_windows(raw);
  if (windows.size() < few) {
    check_commands(table, raw, expected.delta_max);
    health.push_back({Finding::Level::bad, "units",
                      "place, heading, speed and yaw rate are hardly ever read within half a second of each other",
                      "not compared: units, signs and frame are taken on trust"});
    return;
  }
  std::vector<double> speeds;
  for (const SessionWindow& w : windows) speeds.push_back(w.way / w.seconds);
  const double top = top_speed(std::move(speeds));
  if (top < slowest_driving(expected.v_ref))
    refuse(table, "the car is parked: it hardly exceeds " + significant(top) + " m/s; expected driving around " +
                      significant(expected.v_ref) + " m/s");
  const double v_ratio = median_ratio(
      windows, [](const SessionWindow& w) { return std::abs(w.speed) * w.seconds; },
      [](const SessionWindow& w) { return w.way; });
  check_speed(table, v_ratio, side_over_path(windows));
  std::vector<SessionWindow> gentle;
  for (const SessionWindow& w : windows)
    if (std::abs(w.turn) < 2.5) gentle.push_back(w);
  const double w_ratio = median_ratio(
      gentle, [](const SessionWindow& w) { return w.rate * w.seconds; }, [](const SessionWindow& w) { return w.turn; });
  check_rate(table, w_ratio);
  check_commands(table, raw, expected.delta_max);
  // A car that stands points anywhere.
  const double slowest = slow_share * expected.v_ref;
  std::vector<SessionWindow> driven = windows;
  std::erase_if(driven, [&](const SessionWindow& w) { return w.way < slowest * w.seconds; });
  check_frame(table, driven);
  check_steering(table, std::move(driven), slowest);
  health.push_back({Finding::Level::good, "units",
                    "speed over distance " + significant(v_ratio) + ", yaw rate over yaw " + significant(w_ratio),
                    "plausible"});
}

void check_place(const CsvTable& table, const RawLog& raw, const Road& road) {
  const auto median_beyond = [&](double side) {
    std::vector<double> beyond;
    for (std::size_t i = 0, next = 0; i < raw.size(); ++i) {
      const double x = raw.at(i, Channel::x), y = side * raw.at(i, Channel::y);
      if (i < next || std::isnan(x + y)) continue;
      beyond.push_back(road.track().beyond_edge(road.track().locate(x, y)));
      next = i + 10;  // more would tell nothing new
    }
    return upper_median(beyond, 0.0);
  };
  const double beyond_edge = median_beyond(1.0);
  // Half the road's width beyond the edge: a car that leaves its own road stays nearer than that for most of a log.
  const double allowed = 0.5 * road.track().narrowest();
  if (beyond_edge <= allowed) return;
  const std::string found =
      "half of the log lies more than " + significant(beyond_edge) + " m outside \"" + road.track().name() + "\"";
  if (median_beyond(-1.0) <= allowed)
    refuse(table, found +
                      ", and with the sign of y_m changed on it: the frame seems to be left-handed; expected y to "
                      "the left of x");
  refuse(table, found + ": it is from another track; give the right one with --track FILE.csv");
}

}  // namespace gripline::measured
