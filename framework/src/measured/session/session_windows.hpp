// What a session's channels show of the same half seconds, for checks of one against another.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "measured/readings/unit_checks.hpp"
#include "measured/session/session.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {

/// What about half a second shows by different channels, in SI units; NaN where a channel was not read.
struct SessionWindow {
  double begin = 0, seconds = 0;
  double way = NAN, course = NAN;                           // between its ends, by place
  double turn = NAN, heading = NAN;                         // of its ends
  double yaw = NAN;                                         // mean
  double speed = NAN, side = NAN, rate = NAN, steer = NAN;  // means
  double throttle = NAN, gain = NAN;                        // mean of d, change of speed between its ends
};

/// Windows of half a second that overlap by half, up to a second long where rows are sparse; none where rows lie
/// further apart. Channels are bridged over as much as lies between most places, up to 2.5 s.
std::vector<SessionWindow> session_windows(Session session);
/// The same, with channels bridged over at most `longest_bridged` [s].
std::vector<SessionWindow> session_windows(Session session, double longest_bridged);

/// By vx, or where that was not read by place [m/s].
inline double speed_of(const SessionWindow& w) { return std::isnan(w.speed) ? w.way / w.seconds : w.speed; }

/// Receivers show a few centimetres per second for a car at rest, whatever its size.
inline constexpr double standing_speed = 0.1;   // [m/s]
inline constexpr double standing_share = 0.05;  // of the speed that a car drives at: a car that is slower stands
/// The slowest driving of a car that drives at this speed [m/s].
inline double slowest_driving(double speed) { return std::max(standing_speed, standing_share * speed); }
/// What a car exceeds in 2 % of its windows: not what a wrong reading shows. 0 without any [m/s].
inline double top_speed(std::vector<double> of_windows) { return lower_quantile(std::move(of_windows), 0.98, 0.0); }

/// Of a car's typical speed: slower driving shows little of headings, slip angles and steering.
inline constexpr double slow_share = 0.2;

inline constexpr std::size_t least_of_ratio = 10;  // windows that a ratio of channels is the median of

/// By row, whether the car moves in half a second around it: faster than the slowest driving of a car that drives at
/// what it exceeds in 2 % of the windows. True of all rows where no window shows a speed, or none such.
std::vector<bool> moving_rows(const Session& session);
/// The session with the readings only of those rows: while a car stands its channels hardly change, and what is typical
/// of all rows is next to nothing where it stands half of the time.
Session while_moving(Session session);
/// Upper quartile of the speed in the rows in which the car moves, by vx, or where that was not read by place: 0.1 m/s
/// at least, 1 m/s where no speed was read.
double typical_speed(const Session& session);

/// How many times the speed at which the place moves vx is; NaN where they cannot be compared.
double speed_over_path(const std::vector<SessionWindow>& windows);
/// How many times that speed vy is: next to 0 of a car that drives forward.
double side_over_path(const std::vector<SessionWindow>& windows);
/// Whether vx is less than half of the speed at which the place moves and vy is that speed, of whatever sign. A vx that
/// is larger than that speed is in another unit, and so is the vy, of a car that slides.
inline bool velocities_look_swapped(double speed_over_path, double side_over_path) {
  constexpr double most_sideways = 0.5;  // of its speed, that a car moves sideways at throughout
  return std::abs(speed_over_path) < most_sideways && is_about(std::abs(side_over_path));
}

/// Correlation of pairs of values, of windows or of rows.
struct Correlation {
  double n = 0, sx = 0, sy = 0, sxx = 0, syy = 0, sxy = 0;
  void add(double x, double y) { n += 1, sx += x, sy += y, sxx += x * x, syy += y * y, sxy += x * y; }
  /// NaN below twenty pairs, or where one of the two values does not vary.
  double value() const {
    const double vx = sxx - sx * sx / n, vy = syy - sy * sy / n;
    return n < 20 || !(vx > 1e-10 * n) || !(vy > 0.0) ? NAN : (sxy - sx * sy / n) / std::sqrt(vx * vy);
  }
};
/// How much driving a correlation over windows of half a second, which overlap by half, is of [s]; of rows it says
/// nothing.
inline double seconds_of_windows(const Correlation& over_windows) { return 0.25 * over_windows.n; }

/// Steering and the curvature that the car drives, where it is faster than `slowest` [m/s].
Correlation turning_correlation(const std::vector<SessionWindow>& windows, double slowest);

}  // namespace gripline::measured
