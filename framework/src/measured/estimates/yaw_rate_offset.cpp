#include "measured/estimates/yaw_rate_offset.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "measured/estimates/independent_blocks.hpp"
#include "measured/readings/bridged_readings.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

constexpr std::size_t fewest_logs = 4;  // whose spread says anything

/// From one reading of yaw to the next, or of several of them.
struct TurnedBeyondYaw {
  double angle = 0;  // integral of the yaw rate less the change of yaw [rad]
  double time = 0;   // [s]
};

/// Between readings of yaw that follow each other with the yaw rate read all the way. Whole turns do not show.
std::vector<TurnedBeyondYaw> between_readings(const Session& session) {
  constexpr double longest = 1.0;  // [s] from one yaw to the next
  std::vector<TurnedBeyondYaw> out;
  double begin = NAN, yaw = NAN, turned = 0.0;  // since the last reading of yaw
  double last_rate = NAN, last_time = NAN;
  for (std::size_t i = 0; i < session.rows(); ++i) {
    const double t = session.t[i], now = session.at(i, Channel::yaw);
    double rate = session.at(i, Channel::yaw_rate);
    if (std::isnan(rate) && !std::isnan(now)) rate = session.bridge(Channel::yaw_rate, t, INFINITY, even_motion).value;
    if (std::isnan(rate)) continue;
    if (!std::isnan(last_time) && !is_longer(t - last_time, even_motion))
      turned += 0.5 * (t - last_time) * (rate + last_rate);
    else
      yaw = NAN;
    last_rate = rate;
    last_time = t;
    if (std::isnan(now)) continue;
    if (t - begin <= longest && !std::isnan(yaw))
      out.push_back({std::remainder(turned - (now - yaw), 2.0 * std::numbers::pi), t - begin});
    begin = t;
    yaw = now;
    turned = 0.0;
  }
  return out;
}

/// Leaves out where yaw jumps: by more than ten times the median, and than a tenth of a radian, which a coarse yaw
/// may do from step to step.
void leave_out_jumps(std::vector<TurnedBeyondYaw>& all) {
  constexpr double medians = 10.0, least = 0.1;
  if (all.empty()) return;
  std::vector<double> values;
  values.reserve(all.size());
  for (const TurnedBeyondYaw& one : all) values.push_back(one.angle / one.time);
  const double rate = upper_median(values);
  for (std::size_t i = 0; i < all.size(); ++i) values[i] = std::abs(all[i].angle - rate * all[i].time);
  const double most = std::max(medians * upper_median(values), least);
  std::erase_if(all, [&](const TurnedBeyondYaw& one) { return std::abs(one.angle - rate * one.time) > most; });
}

/// Sums over stretches; what is left in the end is one of its own, or, below half of one, part of the last.
void add_stretches(const std::vector<TurnedBeyondYaw>& all, std::vector<TurnedBeyondYaw>& to) {
  std::size_t added = 0;
  TurnedBeyondYaw sum;
  const auto end_stretch = [&] {
    to.push_back(sum);
    sum = {};
    ++added;
  };
  for (const TurnedBeyondYaw& one : all) {
    sum.angle += one.angle;
    sum.time += one.time;
    if (sum.time >= independent_time) end_stretch();
  }
  if (sum.time >= 0.5 * independent_time) {
    end_stretch();
  } else if (added > 0) {
    to.back().angle += sum.angle;
    to.back().time += sum.time;
  }
}

/// Standard error of the ratio `offset` by the spread over so many parts, two or more.
double standard_error(const std::vector<TurnedBeyondYaw>& parts, double offset) {
  double time = 0.0, square = 0.0;
  for (const TurnedBeyondYaw& one : parts) {
    const double off = one.angle - offset * one.time;
    time += one.time;
    square += off * off;
  }
  const auto n = static_cast<double>(parts.size());
  return std::sqrt(square * n / (n - 1.0)) / time;
}

TurnedBeyondYaw sum_of(std::span<const TurnedBeyondYaw> parts) {
  TurnedBeyondYaw sum;
  for (const TurnedBeyondYaw& one : parts) {
    sum.angle += one.angle;
    sum.time += one.time;
  }
  return sum;
}

}  // namespace

std::pair<double, double> YawRateOffset::range() const {
  constexpr double sure = 0.99865;  // of a normal, three standard deviations on one side
  const boost::math::students_t t(static_cast<double>(parts) - 1.0);
  const double half = sigma * boost::math::quantile(t, sure);
  return {value - half, value + half};
}

std::optional<YawRateOffset> yaw_rate_offset(std::span<const Session* const> sessions) {
  std::vector<TurnedBeyondYaw> stretches, logs;
  for (const Session* const session : sessions) {
    if (!session->has[Channel::yaw] || !session->has[Channel::yaw_rate]) continue;
    std::vector<TurnedBeyondYaw> all = between_readings(*session);
    leave_out_jumps(all);
    const std::size_t before = stretches.size();
    add_stretches(all, stretches);
    if (stretches.size() > before) logs.push_back(sum_of(std::span(stretches).subspan(before)));
  }
  if (stretches.size() < 2) return std::nullopt;
  const TurnedBeyondYaw sum = sum_of(stretches);
  const double value = sum.angle / sum.time, of_stretches = standard_error(stretches, value);
  const double of_logs = logs.size() < fewest_logs ? 0.0 : standard_error(logs, value);
  return of_logs > of_stretches ? YawRateOffset{value, of_logs, logs.size()}
                                : YawRateOffset{value, of_stretches, stretches.size()};
}

}  // namespace gripline::measured
