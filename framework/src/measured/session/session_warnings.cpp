#include "measured/session/session_warnings.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <string>

#include "measured/readings/bridged_readings.hpp"
#include "measured/readings/unit_checks.hpp"
#include "measured/session/centre_of_gravity.hpp"
#include "measured/session/session_windows.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

using std::numbers::pi;

/// The speed over that of the path where the two are inconsistent, so in every eighth of the log that shows it; NaN
/// elsewhere. Windows in which a car turns far do not count: their ends lie nearer than the way between them.
double inconsistent_speed_ratio(const std::vector<SessionWindow>& windows) {
  constexpr double off = 0.08, off_in_part = 0.05;
  constexpr double farthest = 0.5;  // [rad]
  constexpr std::size_t parts = 8, least_parts = 4;
  const auto ratio_of = [](std::span<const SessionWindow> some) {
    const auto straight = [](const SessionWindow& w) {
      const double turn = std::isnan(w.turn) ? w.rate * w.seconds : w.turn;
      return std::abs(turn) < farthest || std::isnan(turn);
    };
    return median_ratio(
        some,
        [&](const SessionWindow& w) {
          return straight(w) ? std::copysign(std::hypot(w.speed, std::isnan(w.side) ? 0.0 : w.side), w.speed) : NAN;
        },
        [](const SessionWindow& w) { return w.way / w.seconds; }, least_of_ratio);
  };
  const double all = ratio_of(windows);
  if (!(std::abs(all - 1.0) > off)) return NAN;
  std::size_t counted = 0, agree = 0;
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t from = part * windows.size() / parts, to = (part + 1) * windows.size() / parts;
    const double one = ratio_of(std::span(windows).subspan(from, to - from));
    if (std::isnan(one)) continue;
    ++counted;
    agree += (one - 1.0) * std::copysign(1.0, all - 1.0) > off_in_part ? 1 : 0;
  }
  return counted >= least_parts && agree == counted ? all : NAN;
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
  constexpr double least = 0.0125, farthest = 0.5;  // [rad] of sideslip that counts, of turning within a window
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

/// A row with a place, a heading and vy.
struct Sideways {
  double t, vy;
  double way = 0;  // to the left of the car, since the row before [m]
  double forward = 0;
};

/// Moves of the place from row to row in the car's axes, in stretches without gaps.
std::vector<std::vector<Sideways>> lateral_moves_of(const Session& s) {
  std::vector<std::vector<Sideways>> out;
  double x = NAN, y = NAN, yaw = NAN;
  for (std::size_t i = 0; i < s.rows(); ++i) {
    if (!std::isfinite(s.at(i, Channel::x) + s.at(i, Channel::y))) continue;
    const double heading = s.at(i, Channel::yaw), vy = s.at(i, Channel::vy);
    if (!std::isfinite(heading + vy)) continue;
    Sideways one{s.t[i], vy};
    if (out.empty() || is_longer(s.t[i] - out.back().back().t, even_motion)) {
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
  constexpr double least = 1e-6;  // of the variance that the speed leaves; below it there is only rounding
  const double left = std::min(1.0 - a * a, 1.0 - b * b);
  return left > least ? (all.value() - a * b) / std::sqrt((1.0 - a * a) * (1.0 - b * b)) : NAN;
}

/// The strongest over some spans: the shortest ones miss no quick weave, the longest ones noise of the place.
double sideways_correlation(const Session& s, double slowest) {
  const auto stretches = lateral_moves_of(s);
  double strongest = NAN;
  for (const double span : {0.0, 0.1, 0.2, 0.4}) {
    const double found = sideways_correlation(stretches, span, slowest);
    if (!(std::abs(found) <= std::abs(strongest))) strongest = std::isnan(found) ? strongest : found;
  }
  return strongest;
}

void warn_of_steering(const Session& s, const std::vector<SessionWindow>& windows, double slowest,
                      std::vector<Finding>& out) {
  std::vector<double> angles;
  for (const auto& c : s.command) angles.push_back(c.delta);
  const bool steers = lower_quantile(angles, 0.99) - lower_quantile(angles, 0.01) > 0.005;  // [rad]
  const Correlation turn = turning_correlation(windows, slowest);
  if (steers && seconds_of_windows(turn) >= 20.0 && std::abs(turn.value()) < 0.2)
    out.push_back({Finding::Level::bad, "delta",
                   "and the curvature driven hardly correlate (" + significant(turn.value(), 2) + " over " +
                       significant(seconds_of_windows(turn)) + " s)",
                   "is it the right column?"});
}

void warn_of_speed(const Session& s, const std::vector<SessionWindow>& windows, std::vector<Finding>& out) {
  if (!s.has[Channel::x] || !s.has[Channel::vx]) return;
  if (std::isnan(speed_over_path(windows)))
    out.push_back({Finding::Level::bad, "units", "place and speed are hardly ever read together",
                   "not compared: the unit of vx is taken on trust"});
  else if (const double ratio = inconsistent_speed_ratio(windows); !std::isnan(ratio))
    out.push_back({Finding::Level::bad, "vx", "is " + significant(ratio) + " times the speed at which x and y move",
                   "its scale may be wrong: another unit (mph, km/h), or of a wheel of another size"});
}

void warn_of_yaw(const std::vector<SessionWindow>& windows, double slowest, std::vector<Finding>& out) {
  const auto degrees = [](double radians) { return significant(radians * 180 / pi, 2) + " deg"; };
  if (const auto course = course_for_yaw(windows, slowest))
    out.push_back(
        {Finding::Level::bad, "yaw",
         "is where x and y move, to " + degrees(course->off) + ", though by vy the car moves up to " +
             degrees(course->sideways) + " sideways",
         "looks like the course over ground, as of a receiver: take atan2(vy, vx) off it, or leave yaw out of "
         "the map; or vy is of another point than x and y"});
}

/// The correlation of vy with the place once that is on time, by its delay `late` [s]: that of the place alone, or of
/// the heading too; the larger of both.
double sideways_correlation_on_time(const SessionFile& file, double late, double slowest) {
  double larger = -1.0;
  for (const double of_yaw : {0.0, late}) {
    const double side = sideways_correlation(at_centre_of_gravity(file, {late, of_yaw, 0.0, 0.0}), slowest);
    if (!std::isnan(side)) larger = std::max(larger, side);
  }
  return larger;
}

void warn_of_lateral_speed(const SessionFile& file, const Session& s, double slowest,
                           const std::function<double(const SessionFile&)>& place_is_late, std::vector<Finding>& out) {
  constexpr double against = -0.6;
  double side = s.has[Channel::x] && s.has[Channel::yaw] && s.has[Channel::vy] ? sideways_correlation(s, slowest) : NAN;
  if (!(side < against)) return;
  const double late = place_is_late ? place_is_late(file) : 0.0;
  if (late != 0.0) side = sideways_correlation_on_time(file, late, slowest);
  if (!(side < against)) return;
  out.push_back({Finding::Level::bad, "vy", "moves against the place (correlation " + significant(side, 2) + ")",
                 "its sign is turned, or it is of a point far from the one that x and y show"});
}

}  // namespace

std::vector<Finding> consistency_warnings(const SessionFile& file,
                                          const std::function<double(const SessionFile&)>& place_is_late) {
  const Session s = at_centre_of_gravity(file);
  const std::vector<SessionWindow> windows = session_windows(s);
  const double slowest = slow_share * typical_speed(s);
  std::vector<Finding> out;
  warn_of_steering(s, windows, slowest, out);
  if (!file.derived_velocity) warn_of_speed(s, windows, out);
  if (!file.derived_velocity && !file.derived_yaw) warn_of_yaw(windows, slowest, out);
  warn_of_lateral_speed(file, s, slowest, place_is_late, out);
  return out;
}

}  // namespace gripline::measured
