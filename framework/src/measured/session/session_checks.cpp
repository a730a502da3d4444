// Checks whether numbers fit the map: units, signs and frames, each with its evidence.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>

#include "config/errors.hpp"
#include "measured/readings/bridged_readings.hpp"
#include "measured/readings/held_readings.hpp"
#include "measured/readings/unit_checks.hpp"
#include "measured/session/centre_of_gravity.hpp"
#include "measured/session/session_file.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

using std::numbers::pi;

/// What about half a second shows by different channels; NaN where a channel was not read.
struct SessionWindow {
  double begin = 0, seconds = 0;
  double way = NAN, course = NAN;                           // between its ends, by place
  double turn = NAN, heading = NAN;                         // of its ends
  double yaw = NAN;                                         // mean
  double speed = NAN, side = NAN, rate = NAN, steer = NAN;  // means
  double throttle = NAN, gain = NAN;                        // mean of d, change of speed between its ends
};

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

/// The usual time from one place to the next [s].
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

std::vector<SessionWindow> windows_of(Session s) {
  constexpr double length = 0.5, slowest = 2.5;  // [s]
  // Else channels that are read in few of the rows would hardly be seen at both ends of a window.
  blank_held_places(s);
  const double bridged = std::clamp(1.5 * time_between_places(s), length, slowest);
  s.reading = bridged_readings(s.t, std::move(s.reading), bridged);
  std::vector<SessionWindow> windows;
  std::size_t j = 0;
  for (std::size_t i = 0; i < s.rows(); i = std::max(i + 1, (i + j) / 2)) {
    j = i;
    while (j + 1 < s.rows() && s.t[j] - s.t[i] < length) ++j;
    SessionWindow w;
    w.begin = s.t[i];
    w.seconds = s.t[j] - s.t[i];
    if (w.seconds < length) break;
    if (w.seconds > 2.0 * length) continue;
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

constexpr std::size_t fewest = 10;  // windows of a ratio

/// NaN where they cannot be compared.
double speed_over_path(const std::vector<SessionWindow>& windows) {
  return usual_ratio(
      windows, [](const SessionWindow& w) { return w.speed; }, [](const SessionWindow& w) { return w.way / w.seconds; },
      fewest);
}

/// How many times the turning of the path the yaw turns, from window to window; NaN where they cannot be compared.
double yaw_over_path(const std::vector<SessionWindow>& windows) {
  struct Turn {
    double yaw, path;
  };
  std::vector<Turn> turns;
  for (std::size_t i = 1; i < windows.size(); ++i) {
    const SessionWindow &a = windows[i - 1], &b = windows[i];
    if (b.begin - a.begin < 0.6 * a.seconds)
      turns.push_back({b.heading - a.heading, std::remainder(b.course - a.course, 2.0 * pi)});
  }
  return usual_ratio(
      turns, [](const Turn& t) { return t.yaw; }, [](const Turn& t) { return t.path; }, fewest);
}

/// The speed over that of the path where it is surely another, so in every eighth of the log that tells it; NaN
/// elsewhere. Windows in which a car turns far do not count: their ends lie nearer than the way between them.
double speed_surely_off(const std::vector<SessionWindow>& windows) {
  constexpr double off = 0.08, surely = 0.05;
  constexpr double farthest = 0.5;  // [rad]
  constexpr std::size_t parts = 8, least_parts = 4;
  const auto ratio_of = [](std::span<const SessionWindow> some) {
    const auto straight = [](const SessionWindow& w) {
      const double turn = std::isnan(w.turn) ? w.rate * w.seconds : w.turn;
      return std::abs(turn) < farthest || std::isnan(turn);
    };
    return usual_ratio(
        some,
        [&](const SessionWindow& w) {
          return straight(w) ? std::copysign(std::hypot(w.speed, std::isnan(w.side) ? 0.0 : w.side), w.speed) : NAN;
        },
        [](const SessionWindow& w) { return w.way / w.seconds; }, fewest);
  };
  const double all = ratio_of(windows);
  if (!(std::abs(all - 1.0) > off)) return NAN;
  std::size_t told = 0, agree = 0;
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t from = part * windows.size() / parts, to = (part + 1) * windows.size() / parts;
    const double one = ratio_of(std::span(windows).subspan(from, to - from));
    if (std::isnan(one)) continue;
    ++told;
    agree += (one - 1.0) * std::copysign(1.0, all - 1.0) > surely ? 1 : 0;
  }
  return told >= least_parts && agree == told ? all : NAN;
}

/// By how much all but a tenth of some angles are off their median.
double spread_of(std::vector<double> angles) {
  const double centre = median(angles);
  for (double& angle : angles) angle = std::abs(angle - centre);
  return lower_quantile(std::move(angles), 0.9);
}
/// And off a line over `by`.
double spread_about_line(std::vector<double> angles, const std::vector<double>& by) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < angles.size(); ++i)
    n += 1, sx += by[i], sy += angles[i], sxx += by[i] * by[i], sxy += by[i] * angles[i];
  const double variance = sxx - sx * sx / n, slope = variance > 0.0 ? (sxy - sx * sy / n) / variance : 0.0;
  for (std::size_t i = 0; i < angles.size(); ++i)
    angles[i] = std::abs(angles[i] - (sy - slope * sx) / n - slope * by[i]);
  return lower_quantile(std::move(angles), 0.9);
}

/// A yaw that is the direction in which the place moves, though the car moves sideways by its vy.
struct CourseForYaw {
  double off = 0, sideways = 0;  // spread of the yaw about the course, and of the sideslip by vy [rad]
};
/// Nothing where the sideslip hardly does more than follow the curvature: so does vy of a point behind the other.
std::optional<CourseForYaw> course_for_yaw(const std::vector<SessionWindow>& windows, double slowest) {
  constexpr double least = 0.0125, farthest = 0.5;  // [rad] of sideslip that tells, of turning within a window
  constexpr double close = 0.35;                    // of the sideslip
  constexpr std::size_t enough = 80;
  std::vector<double> off, sideslip, curvature;
  for (const SessionWindow& w : windows) {
    if (!(w.speed > slowest) || !(std::abs(w.turn) < farthest) || !std::isfinite(w.course + w.yaw + w.side)) continue;
    sideslip.push_back(std::atan2(w.side, w.speed));
    off.push_back(std::remainder(w.course - w.yaw, 2.0 * pi));
    curvature.push_back(w.turn / w.seconds / w.speed);
  }
  if (off.size() < enough) return std::nullopt;
  const CourseForYaw found{spread_of(std::move(off)), spread_of(sideslip)};
  if (found.off > close * found.sideways || spread_about_line(std::move(sideslip), curvature) < least)
    return std::nullopt;
  return found;
}

/// Correlation of two values over windows.
struct Correlation {
  double n = 0, sx = 0, sy = 0, sxx = 0, syy = 0, sxy = 0;
  void add(double x, double y) { n += 1, sx += x, sy += y, sxx += x * x, syy += y * y, sxy += x * y; }
  /// NaN below twenty windows, or where one of them does not vary.
  double value() const {
    const double vx = sxx - sx * sx / n, vy = syy - sy * sy / n;
    return n < 20 || !(vx > 1e-10 * n) || !(vy > 0.0) ? NAN : (sxy - sx * sy / n) / std::sqrt(vx * vy);
  }
  double seconds() const { return 0.25 * n; }  // windows of half a second overlap by half
};

double speed_of(const SessionWindow& w) { return std::isnan(w.speed) ? w.way / w.seconds : w.speed; }

/// Steering and the curvature that the car drives, where it is faster than `slowest`.
Correlation turning(const std::vector<SessionWindow>& windows, double slowest) {
  Correlation all;
  for (const SessionWindow& w : windows) {
    const double rate = std::isnan(w.rate) ? w.turn / w.seconds : w.rate, v = speed_of(w);
    if (v > slowest && std::isfinite(rate)) all.add(w.steer, rate / v);
  }
  return all;
}

/// How throttle and acceleration of a car that drives faster than `slowest` go together, without what the speed tells
/// of both: drag lets a driver push more and the car gain less.
struct Pushing {
  double correlation = NAN;  // NaN where it cannot be told
  double seconds = 0;
};
Pushing pushing(const std::vector<SessionWindow>& windows, double slowest) {
  Correlation all, throttle, gain;
  for (const SessionWindow& w : windows) {
    const double v = speed_of(w);
    if (!(v > slowest) || !std::isfinite(w.throttle + w.gain)) continue;
    all.add(w.throttle, w.gain / w.seconds);
    throttle.add(w.throttle, v), gain.add(w.gain / w.seconds, v);
  }
  const double a = throttle.value(), b = gain.value(), left = (1.0 - a * a) * (1.0 - b * b);
  if (!std::isfinite(a + b)) return {all.value(), all.seconds()};  // the speed does not vary
  return {left > 1e-6 ? (all.value() - a * b) / std::sqrt(left) : NAN, all.seconds()};
}

/// A row with a place, a heading and vy.
struct Sideways {
  double t, vy;
  double way = 0;  // to the left of the car, since the row before [m]
  double forward = 0;
};

/// Moves of the place from row to row in the car's axes, in stretches without gaps.
std::vector<std::vector<Sideways>> sideways_of(const Session& s) {
  constexpr double gap = 0.25;  // [s]
  std::vector<std::vector<Sideways>> out;
  double x = NAN, y = NAN, yaw = NAN;
  for (std::size_t i = 0; i < s.rows(); ++i) {
    if (!std::isfinite(s.at(i, Channel::x) + s.at(i, Channel::y))) continue;
    const double heading = s.at(i, Channel::yaw), vy = s.at(i, Channel::vy);
    if (!std::isfinite(heading + vy)) continue;
    Sideways one{s.t[i], vy};
    if (out.empty() || s.t[i] - out.back().back().t > gap) {
      out.emplace_back();
    } else {
      const double dx = s.at(i, Channel::x) - x, dy = s.at(i, Channel::y) - y, middle = 0.5 * (yaw + heading);
      one.way = dy * std::cos(middle) - dx * std::sin(middle);
      one.forward = dx * std::cos(middle) + dy * std::sin(middle);
    }
    x = s.at(i, Channel::x), y = s.at(i, Channel::y), yaw = heading;
    out.back().push_back(one);
  }
  return out;
}

/// vy and the central difference of the place across the car, about every row and over `span` seconds (two rows at
/// least); NaN below five seconds of driving. A heading that is turned by a little adds a share of the speed, which is
/// taken off both.
double sideways_correlation(const std::vector<std::vector<Sideways>>& stretches, double span, double slowest) {
  constexpr double enough = 5.0;  // [s]
  Correlation all, read, moved;   // with each other, and each with the speed
  double driven = 0.0;
  for (const auto& rows : stretches)
    for (std::size_t first = 0, last = 0; first + 2 < rows.size(); ++first) {
      last = std::max(last, first + 2);
      while (last + 1 < rows.size() && rows[last].t - rows[first].t < span - 1e-6) ++last;
      const double seconds = rows[last].t - rows[first].t;
      if (seconds < span - 1e-6) break;
      double way = 0.0, forward = 0.0, vy = 0.0;
      for (std::size_t i = first + 1; i <= last; ++i) {
        way += rows[i].way / seconds, forward += rows[i].forward / seconds;
        vy += 0.5 * (rows[i].vy + rows[i - 1].vy) * (rows[i].t - rows[i - 1].t) / seconds;
      }
      if (!(forward > slowest)) continue;
      driven += rows[first + 1].t - rows[first].t;
      all.add(vy, way), read.add(vy, forward), moved.add(way, forward);
    }
  if (driven < enough) return NAN;
  const double a = read.value(), b = moved.value();
  if (!std::isfinite(a + b)) return all.value();  // the speed does not vary
  constexpr double least = 1e-6;  // of the variance that the speed leaves; below it nothing is told but rounding
  const double left = std::min(1.0 - a * a, 1.0 - b * b);
  return left > least ? (all.value() - a * b) / std::sqrt((1.0 - a * a) * (1.0 - b * b)) : NAN;
}

/// The strongest over some spans: the shortest ones miss no quick weave, the longest ones noise of the place.
double sideways_correlation(const Session& s, double slowest) {
  const auto stretches = sideways_of(s);
  double strongest = NAN;
  for (const double span : {0.0, 0.1, 0.2, 0.4}) {
    const double found = sideways_correlation(stretches, span, slowest);
    if (!(std::abs(found) <= std::abs(strongest))) strongest = std::isnan(found) ? strongest : found;
  }
  return strongest;
}

class Checks {
 public:
  Checks(const SessionFile& file, double v_ref)
      : s_(at_centre_of_gravity(file)), v_ref_(v_ref), windows_(windows_of(s_)) {}

  void run(bool derived) const {
    commands();
    moving();
    throttle();
    if (!derived) speed();
    yaw();
    heading();
    steering();
  }

 private:
  [[noreturn]] void refuse(const std::string& message) const {
    Diagnostic d;
    d.file = s_.name;
    d.message = message;
    throw InputError({d});
  }

  void throttle() const {
    if (s_.prescribed_speed) return;
    only_braking();
    constexpr double enough = 20.0;  // [s]
    const Pushing found = pushing(windows_, 0.2 * v_ref_);
    if (found.seconds >= enough && found.correlation < -0.4)
      refuse("the car speeds up against its throttle: d and acceleration correlate at " +
             significant(found.correlation) + " over " + significant(found.seconds) +
             " s of driving; expected a positive one: turn d's sign (\"sign\": -1), or vx");
  }

  /// A car whose d is never above 0 cannot gain speed.
  void only_braking() const {
    std::vector<double> d;
    for (const auto& c : s_.command) d.push_back(c.d);
    const double high = lower_quantile(d, 0.99), low = lower_quantile(d, 0.01);
    if (high > 0.02 || low > -0.1) return;
    double slowest = INFINITY, from = 0.0, to = 0.0;
    for (const SessionWindow& w : windows_) {
      const double v = std::abs(speed_of(w));
      if (v < slowest) slowest = v;
      if (v - slowest > to - from) from = slowest, to = v;
    }
    if (!(to - from > 0.3 * v_ref_)) return;
    const std::string sped = ", but the car speeds up from " + significant(from) + " to " + significant(to) + " m/s: ";
    const std::string found = " (" + significant(low) + " to " + significant(high) + ")";
    if (high > 0.0)
      refuse("d is hardly ever above 0" + found + sped +
             "the scale of its throttle is wrong (1 is full throttle; is it divided by 100 twice?), or its sign "
             "(\"sign\": -1)");
    refuse("d is never above 0" + found + ", which brakes" + sped +
           "turn its sign (\"sign\": -1), or add the throttle");
  }

  void commands() const {
    std::vector<double> d, delta;
    for (const auto& c : s_.command) d.push_back(std::abs(c.d)), delta.push_back(std::abs(c.delta));
    const double most_d = lower_quantile(d, 0.99), most_delta = lower_quantile(delta, 0.99);
    if (most_d > 1.5)
      refuse("d reaches " + significant(most_d) + "; throttle is 0 to 1 and brake 0 to -1: " +
             (most_d < 150 ? "it looks like per cent (divide by 100)"
                           : "a pressure needs its largest value to divide by"));
    if (most_delta > 1.6)
      refuse("delta reaches " + significant(most_delta) +
             " rad, which no wheel turns: it looks like degrees (\"unit\": "
             "\"deg\") or the angle of the steering wheel (divide by the steering ratio)");
  }

  void moving() const {
    std::vector<double> speeds;
    for (const SessionWindow& w : windows_)
      if (std::isfinite(speed_of(w))) speeds.push_back(std::abs(speed_of(w)));
    const double most = lower_quantile(speeds, 0.98);
    if (speeds.size() < 10) refuse("fewer than 5 s with readings; 60 s are good");
    // Receivers show a few centimetres per second for a car at rest, whatever its size.
    constexpr double standing = 0.1;  // [m/s]
    if (most < std::max(standing, 0.05 * v_ref_))
      refuse("the car is parked: its speed stays below " + significant(most) + " m/s; expected a log of driving" +
             (most >= standing ? " (at about " + significant(v_ref_) + " m/s, by the world)" : ""));
  }

  void speed() const {
    const double ratio = speed_over_path(windows_);
    if (std::isnan(ratio) || (ratio > 0.6 && ratio < 1.6)) return;
    const std::string found = "vx is " + significant(ratio) + " times the speed at which x and y move";
    if (ratio < -0.6 && ratio > -1.6) refuse(found + ": its sign is turned (\"sign\": -1), or the car drives backward");
    constexpr double no_car = 100.0;  // [m/s] a millimetre per second of the slowest one is more
    std::vector<double> speeds;
    for (const SessionWindow& w : windows_)
      if (std::isfinite(w.speed)) speeds.push_back(std::abs(w.speed));
    if (ratio > 700 && ratio < 1400 && lower_quantile(speeds, 0.9) < no_car)
      refuse(found + ": x and y were taken for millimetres and are metres");
    for (const WrongUnit& u : wrong_units)
      if (ratio > u.low && ratio < u.high)
        refuse(found + (u.of_place ? ": x and y look like " : ": vx looks like ") + u.name + " (\"unit\": \"" + u.unit +
               "\")");
    if (ratio > 1 / 3.8 && ratio < 1 / 3.45) refuse(found + ": vx was taken for km/h and is m/s");
    refuse(found + "; expected about 1");
  }

  void yaw() const {
    const double ratio = usual_ratio(
        windows_, [](const SessionWindow& w) { return w.rate; },
        [](const SessionWindow& w) { return w.turn / w.seconds; }, fewest);
    if (std::isnan(ratio) || (ratio > 0.3 && ratio < 3.0)) return;
    const std::string found = "yaw_rate is " + significant(ratio) + " times the rate of yaw";
    // Which of the two is wrong, the path tells.
    const double by_path = yaw_over_path(windows_);
    if (ratio > 30 && ratio < 90)
      refuse(found + (by_path > 1.0 / 90 && by_path < 1.0 / 30 ? ": yaw was taken for degrees and is radians"
                                                               : ": it looks like deg/s (\"unit\": \"deg/s\")"));
    if (ratio > 1.0 / 90 && ratio < 1.0 / 30)
      refuse(found +
             (by_path > 0.5 && by_path < 2.0
                  ? ", which turns as the path does: yaw_rate was taken for deg/s and is rad/s (\"unit\": \"rad/s\")"
                  : ": yaw looks like degrees (\"unit\": \"deg\")"));
    if (ratio < -0.3 && ratio > -3.0) refuse(found + ": one of them has the other sign (\"sign\": -1)");
  }

  /// Heading against course. A compass runs clockwise from north, this project's yaw counter-clockwise from +x.
  void heading() const {
    std::vector<double> off, against;
    for (const SessionWindow& w : windows_) {
      if (!(std::abs(speed_of(w)) > 0.2 * v_ref_) || !std::isfinite(w.course + w.heading)) continue;
      off.push_back(std::remainder(w.heading - w.course, 2 * pi));
      against.push_back(std::remainder(w.heading + w.course, 2 * pi));
    }
    if (off.size() < 20) return;
    const auto spread = [](const std::vector<double>& angles, double& centre) {
      double s = 0.0, c = 0.0;
      for (const double a : angles) s += std::sin(a), c += std::cos(a);
      centre = std::atan2(s, c);
      return 1.0 - std::hypot(s, c) / static_cast<double>(angles.size());
    };
    double centre = 0.0, mirrored = 0.0;
    const double loose = spread(off, centre), loose_mirrored = spread(against, mirrored);
    if (loose < 0.3 && std::abs(centre) < 0.6) return;
    const std::string degrees = significant(centre * 180 / pi) + " deg";
    if (loose < 0.1 && std::abs(std::abs(centre) - pi) < 0.3)
      refuse("yaw points backward: it is " + degrees + " off the path; add pi to it");
    if (loose < 0.1)
      refuse("yaw is " + degrees + " off the path; expected the direction of x and y, from +x to the left");
    double widest = 0.0;
    for (const double yaw : s_.written_yaw)
      if (!std::isnan(yaw)) widest = std::max(widest, std::abs(yaw));
    if (widest > 0.5 * pi * pi / 180 && widest < 2.1 * pi * pi / 180)
      refuse("yaw stays within " + significant(widest) +
             " rad and the path does not: yaw was taken for degrees and is radians");
    if (loose_mirrored < 0.1)
      refuse("yaw turns against the path: yaw plus the path's angle is always " + significant(mirrored * 180 / pi) +
             " deg; a compass counts clockwise (\"formula\": \"pi/2 - rad(heading)\"), or y points to the right");
    refuse("yaw and the path of x and y do not belong together (spread " + significant(loose) + " of 1)");
  }

  void steering() const {
    const Correlation found = turning(windows_, 0.2 * v_ref_);
    if (found.value() < -0.4)
      refuse("the car turns against its steering: delta and curvature correlate at " + significant(found.value()) +
             " over " + significant(found.seconds()) +
             " s of driving; expected a positive one: turn delta's sign (\"sign\": -1), or yaw and y");
  }

  const Session s_;
  double v_ref_;
  std::vector<SessionWindow> windows_;
};

void doubt_steering(const Session& s, const std::vector<SessionWindow>& windows, double slowest,
                    std::vector<Finding>& out) {
  std::vector<double> angles;
  for (const auto& c : s.command) angles.push_back(c.delta);
  const bool steers = lower_quantile(angles, 0.99) - lower_quantile(angles, 0.01) > 0.005;  // [rad]
  const Correlation turn = turning(windows, slowest);
  if (steers && turn.seconds() >= 20.0 && std::abs(turn.value()) < 0.2)
    out.push_back({Finding::Level::bad, "delta",
                   "and the curvature driven hardly correlate (" + significant(turn.value(), 2) + " over " +
                       significant(turn.seconds()) + " s)",
                   "is it the right column?"});
}

void doubt_speed(const Session& s, const std::vector<SessionWindow>& windows, std::vector<Finding>& out) {
  if (!s.has[Channel::x] || !s.has[Channel::vx]) return;
  if (std::isnan(speed_over_path(windows)))
    out.push_back({Finding::Level::bad, "units", "place and speed are hardly ever read together",
                   "not compared: the unit of vx is taken on trust"});
  else if (const double ratio = speed_surely_off(windows); !std::isnan(ratio))
    out.push_back({Finding::Level::bad, "vx", "is " + significant(ratio) + " times the speed at which x and y move",
                   "its scale may be wrong: another unit (mph, km/h), or of a wheel of another size"});
}

void doubt_yaw(const std::vector<SessionWindow>& windows, double slowest, std::vector<Finding>& out) {
  const auto degrees = [](double radians) { return significant(radians * 180 / pi, 2) + " deg"; };
  if (const auto course = course_for_yaw(windows, slowest))
    out.push_back(
        {Finding::Level::bad, "yaw",
         "is where x and y move, to " + degrees(course->off) + ", though by vy the car moves up to " +
             degrees(course->sideways) + " sideways",
         "looks like the course over ground, as of a receiver: take atan2(vy, vx) off it, or leave yaw out of "
         "the map; or vy is of another point than x and y"});
}

void doubt_side(const Session& s, double slowest, std::vector<Finding>& out) {
  constexpr double against = -0.6;
  const double side =
      s.has[Channel::x] && s.has[Channel::yaw] && s.has[Channel::vy] ? sideways_correlation(s, slowest) : NAN;
  if (side < against)
    out.push_back({Finding::Level::bad, "vy", "moves against the place (correlation " + significant(side, 2) + ")",
                   "its sign is turned, or it is of a point far from the one that x and y show"});
}

}  // namespace

std::vector<Finding> doubts_about(const SessionFile& file) {
  const Session s = at_centre_of_gravity(file);
  const std::vector<SessionWindow> windows = windows_of(s);
  const double slowest = 0.2 * typical_speed(s);
  std::vector<Finding> out;
  doubt_steering(s, windows, slowest, out);
  if (!file.derived_velocity) doubt_speed(s, windows, out);
  if (!file.derived_velocity && !file.derived_yaw) doubt_yaw(windows, slowest, out);
  doubt_side(s, slowest, out);
  return out;
}

void check_session(const SessionFile& file, double v_ref) { Checks(file, v_ref).run(file.derived_velocity); }

}  // namespace gripline::measured
