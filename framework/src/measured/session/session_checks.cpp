#include "measured/session/session_checks.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "config/errors.hpp"
#include "measured/readings/directions.hpp"
#include "measured/readings/unit_checks.hpp"
#include "measured/session/centre_of_gravity.hpp"
#include "measured/session/session_windows.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

using std::numbers::pi;

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
  return median_ratio(
      turns, [](const Turn& t) { return t.yaw; }, [](const Turn& t) { return t.path; }, least_of_ratio);
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
  if (!std::isfinite(a + b)) return {all.value(), seconds_of_windows(all)};  // the speed does not vary
  return {left > 1e-6 ? (all.value() - a * b) / std::sqrt(left) : NAN, seconds_of_windows(all)};
}

class Checks {
 public:
  Checks(const SessionFile& file, double v_ref, double delta_max)
      : s_(at_centre_of_gravity(file)), v_ref_(v_ref), delta_max_(delta_max), windows_(session_windows(s_)) {}

  void run(bool derived) const {
    commands();
    if (!derived) velocity_axes();
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
    const Pushing found = pushing(windows_, slow_share * v_ref_);
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
    if (most_d > most_pedal)
      refuse("d reaches " + significant(most_d) + "; throttle is 0 to 1 and brake 0 to -1: " +
             (most_d < 150 ? "it looks like per cent (divide by 100)"
                           : "a pressure needs its largest value to divide by"));
    if (most_delta > most_steering)
      refuse("delta reaches " + significant(most_delta) +
             " rad, which no wheel turns: it looks like degrees (\"unit\": "
             "\"deg\") or the angle of the steering wheel (divide by the steering ratio)");
    const double steered = lower_quantile(delta, often_steered);
    if (is_of_handwheel(steered, delta_max_))
      refuse(
          "delta reaches " + significant(steered) + " rad, and the world's delta_max is " + significant(delta_max_) +
          ": it looks like the angle of the steering wheel; expected that of the road wheels (divide by the steering "
          "ratio), or a delta_max of this car");
  }

  /// Asked first: by its sideslip as forward speed a car stands, or its place is in another unit.
  void velocity_axes() const {
    std::vector<double> ways;
    for (const SessionWindow& w : windows_)
      if (std::isfinite(w.way)) ways.push_back(w.way / w.seconds);
    if (top_speed(std::move(ways)) < slowest_driving(v_ref_)) return;
    const double speed = speed_over_path(windows_), side = side_over_path(windows_);
    if (velocities_look_swapped(speed, side))
      refuse("vx is " + significant(speed) + " times the speed at which x and y move, vy " + significant(side) +
             " times: vx and vy look swapped");
  }

  void moving() const {
    std::vector<double> speeds;
    for (const SessionWindow& w : windows_)
      if (std::isfinite(speed_of(w))) speeds.push_back(std::abs(speed_of(w)));
    constexpr std::size_t fewest = 10;
    if (speeds.size() < fewest)
      refuse("only " + std::to_string(speeds.size()) + " half seconds with a speed or a way, which overlap by half; " +
             std::to_string(fewest) + " are needed, some 3 s, and 60 s are good");
    const double most = top_speed(std::move(speeds));
    if (most < slowest_driving(v_ref_))
      refuse("the car is parked: its speed stays below " + significant(most) + " m/s; expected a log of driving" +
             (most >= standing_speed ? " (at about " + significant(v_ref_) + " m/s, by the world)" : ""));
  }

  void speed() const {
    const double ratio = speed_over_path(windows_);
    if (std::isnan(ratio) || is_about(ratio)) return;
    const std::string found = "vx is " + significant(ratio) + " times the speed at which x and y move";
    if (is_about(-ratio)) refuse(found + ": its sign is turned (\"sign\": -1), or the car drives backward");
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
    const double ratio = median_ratio(
        windows_, [](const SessionWindow& w) { return w.rate; },
        [](const SessionWindow& w) { return w.turn / w.seconds; }, least_of_ratio);
    if (std::isnan(ratio) || (ratio > 0.3 && ratio < 3.0)) return;
    const std::string found = "yaw_rate is " + significant(ratio) + " times the rate of yaw";
    const bool turned = has_other_sign(ratio);
    const std::string sign = turned ? "; one of them has the other sign, too (\"sign\": -1)" : "";
    // Which of the two is wrong, the path tells.
    const double by_path = std::abs(yaw_over_path(windows_));
    if (is_of_degrees(std::abs(ratio)))
      refuse(found +
             (is_over_degrees(by_path) ? ": yaw was taken for degrees and is radians"
                                       : ": it looks like deg/s (\"unit\": \"deg/s\")") +
             sign);
    if (is_over_degrees(std::abs(ratio)))
      refuse(found +
             (by_path > 0.5 && by_path < 2.0
                  ? ", which turns as the path does: yaw_rate was taken for deg/s and is rad/s (\"unit\": \"rad/s\")"
                  : ": yaw looks like degrees (\"unit\": \"deg\")") +
             sign);
    if (turned) refuse(found + ": one of them has the other sign (\"sign\": -1)");
  }

  /// Heading against course. A compass runs clockwise from north, this project's yaw counter-clockwise from +x.
  void heading() const {
    constexpr double slides = 0.5, mostly = 0.6;  // [rad] off the path; share of the windows that are not
    constexpr double spins = 0.5;                 // [rad/s]: a yaw that stands still beside the path is no spin
    std::vector<double> off, against, turning;
    for (const SessionWindow& w : windows_) {
      if (!(std::abs(speed_of(w)) > slow_share * v_ref_) || !std::isfinite(w.course + w.heading)) continue;
      off.push_back(std::remainder(w.heading - w.course, 2 * pi));
      against.push_back(std::remainder(w.heading + w.course, 2 * pi));
      if (std::abs(off.back()) > slides) turning.push_back(std::abs(w.turn) / w.seconds);
    }
    if (off.size() < 20) return;
    const std::complex<double> direct = mean_direction(off), mirrored = mean_direction(against);
    if (are_about_zero(direct)) return;
    const double centre = std::arg(direct);
    const std::string degrees = significant(centre * 180 / pi) + " deg";
    if (are_alike(direct) && std::abs(std::abs(centre) - pi) < 0.3)
      refuse("yaw points backward: it is " + degrees + " off the path; add pi to it");
    if (are_alike(direct))
      refuse("yaw is " + degrees + " off the path; expected the direction of x and y, from +x to the left");
    double widest = 0.0;
    for (const double yaw : s_.written_yaw)
      if (!std::isnan(yaw)) widest = std::max(widest, std::abs(yaw));
    if (widest > 0.5 * pi * pi / 180 && widest < 2.1 * pi * pi / 180)
      refuse("yaw stays within " + significant(widest) +
             " rad and the path does not: yaw was taken for degrees and is radians");
    if (are_alike(mirrored))
      refuse("yaw turns against the path: yaw plus the path's angle is always " +
             significant(std::arg(mirrored) * 180 / pi) +
             " deg; a compass counts clockwise (\"formula\": \"pi/2 - rad(heading)\"), or y points to the right" +
             (is_about_a_quarter(mirrored) ? ", or x and y are swapped" : ""));
    // A car that spins now and then points elsewhere than it goes.
    const bool few = static_cast<double>(turning.size()) < (1.0 - mostly) * static_cast<double>(off.size());
    if (few && upper_median(std::move(turning), 0.0) > spins) return;
    refuse("yaw and the path of x and y do not belong together (spread " + significant(1.0 - std::abs(direct)) +
           " of 1)" +
           (widest > 2.5 * pi ? "; yaw goes to " + significant(widest) +
                                    ": is it in degrees (\"unit\": \"deg\"; in a formula, rad(...))?"
                              : ""));
  }

  void steering() const {
    const Correlation found = turning_correlation(windows_, slow_share * v_ref_);
    if (found.value() < -0.4)
      refuse("the car turns against its steering: delta and curvature correlate at " + significant(found.value()) +
             " over " + significant(seconds_of_windows(found)) +
             " s of driving; expected a positive one: turn delta's sign (\"sign\": -1), or yaw and y");
  }

  const Session s_;
  double v_ref_, delta_max_;
  std::vector<SessionWindow> windows_;
};

}  // namespace

void check_session(const SessionFile& file, double v_ref, double delta_max) {
  Checks(file, v_ref, delta_max).run(file.derived_velocity);
}

}  // namespace gripline::measured
