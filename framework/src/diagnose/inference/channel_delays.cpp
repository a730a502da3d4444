#include "diagnose/inference/channel_delays.hpp"

#include <algorithm>
#include <array>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <utility>

#include "diagnose/thresholds.hpp"
#include "measured/estimates/session_delays.hpp"
#include "measured/readings/bridged_readings.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::diagnose {
namespace {

using measured::channels;
using measured::Log;

/// All logs one after the other, with pauses that nothing is interpolated over.
measured::Session session_of(std::span<const LogFile> logs) {
  constexpr double pause = 10.0;  // [s]
  measured::Session session;
  session.has.fill(true);
  double begin = 0.0;
  for (const LogFile& file : logs) {
    double end = begin;
    for (const Log& log : file.stretches)
      for (std::size_t k = 0; k < log.size(); ++k) {
        end = begin + log.t0 + static_cast<double>(k) * log.dt;
        session.t.push_back(end);
        session.command.push_back(log.command[k]);
        const auto row = log.reading.begin() + static_cast<std::ptrdiff_t>(k * channels);
        session.reading.insert(session.reading.end(), row, row + channels);
      }
    begin = end + pause;
  }
  return session;
}

double longest_step(std::span<const LogFile> logs) {
  double dt = 0.0;
  for (const LogFile& file : logs)
    for (const Log& log : file.stretches) dt = std::max(dt, log.dt);
  return dt;
}

/// Readings of one channel `seconds` later, linear between samples, where the nearer of these has one. `bridged`: the
/// log's readings, with those that are missing between two filled in.
std::vector<double> read_later(const Log& log, std::span<const double> bridged, std::size_t channel, double seconds) {
  std::vector<double> out(log.size(), not_a_number);
  const auto last = static_cast<double>(log.size() - 1);
  for (std::size_t k = 0; k < log.size(); ++k) {
    const double at = static_cast<double>(k) + seconds / log.dt;
    if (!(at >= 0.0) || !(at <= last)) continue;
    const auto i = std::min(static_cast<std::size_t>(at), log.size() - 2);
    const double share = at - static_cast<double>(i), a = bridged[i * channels + channel],
                 b = bridged[(i + 1) * channels + channel];
    if (std::isnan(log.reading[(share < 0.5 ? i : i + 1) * channels + channel])) continue;
    out[k] = share == 0.0 ? a : share == 1.0 ? b : a + share * (b - a);
  }
  return out;
}

/// A log's readings with short gaps bridged.
std::vector<double> bridged_readings_of(const Log& log) {
  std::vector<double> t(log.size());
  for (std::size_t k = 0; k < t.size(); ++k) t[k] = static_cast<double>(k) * log.dt;
  return measured::bridged_readings(t, log.reading, measured::even_motion);
}

/// By group: the one that shows the same motion, place and speeds, yaw and yaw rate.
constexpr std::array<std::size_t, measured::delay_groups> partner = {2, 3, 0, 1};

std::string words_of(std::size_t group) {
  std::string words = measured::delay_names[group];
  std::ranges::replace(words, '_', ' ');
  return words;
}

/// Place and yaw that may be late by the same time are late together, as readings of one pose: by what is known better.
void join_pose(std::vector<ChannelDelay>& delays) {
  if (delays.size() != 2 || delays[0].group > 1 || delays[1].group > 1) return;
  if (delays[0].low > delays[1].high || delays[1].low > delays[0].high) return;
  const auto width = [](const ChannelDelay& d) { return d.high - d.low; };
  const ChannelDelay better = width(delays[0]) < width(delays[1]) ? delays[0] : delays[1];
  for (ChannelDelay& d : delays) d.seconds = better.seconds, d.low = better.low, d.high = better.high;
}

/// The interval that misses a delay with this probability. That of few blocks drawn anew is a normal's, of a spread
/// that falls short by the root of (n - 1) / n: Student's is as wide as it must be.
std::pair<double, double> interval(const measured::PairDelay& d, double missing) {
  const auto n = static_cast<double>(d.blocks);  // 3 at least
  const boost::math::students_t student(n - 1.0);
  const double wider = boost::math::quantile(student, 1.0 - 0.5 * missing) * std::sqrt(n / (n - 1.0)) / normal_95;
  return {d.seconds - wider * (d.seconds - d.low), d.seconds + wider * (d.high - d.seconds)};
}

/// The 95 % interval of a delay, which also misses it by what readings do between samples.
std::pair<double, double> stated_interval(const measured::PairDelay& d, double dt) {
  const auto [low, high] = interval(d, 0.05);
  const double unseen = normal_95 * thresholds::delay_between_samples * dt;
  return {d.seconds - std::hypot(d.seconds - low, unseen), d.seconds + std::hypot(high - d.seconds, unseen)};
}

/// By what a fit moved the delay of a group.
struct LeftOver {
  std::size_t group = 0;
  double seconds = 0, sigma = 0;
  double range = 0;  // [s] to either side that was left open
  bool at_limit = false;
};

std::vector<LeftOver> left_over(const Catalogue& catalogue, const Fit& fit) {
  std::vector<LeftOver> out;
  const auto nuisances = catalogue.nuisances();
  const std::size_t p = fit.theta.size();
  if (p < nuisances.size() || fit.covariance.size() != p * p) return out;
  for (std::size_t i = 0; i < nuisances.size(); ++i) {
    if (!nuisances[i].delay) continue;
    const double moved = fit.theta[i] - nuisances[i].nominal, range = thresholds::nuisance_limit * nuisances[i].sigma,
                 sigma = std::sqrt(std::max(0.0, fit.covariance[i * p + i]));
    out.push_back({*nuisances[i].delay, moved, sigma, range, std::abs(moved) > 0.99 * range});
  }
  return out;
}

bool is_significant(const measured::PairDelay& d, double dt) {
  const auto [low, high] = interval(d, thresholds::false_delay);
  const double least = std::min(std::abs(low), std::abs(high));
  return low * high > 0.0 && least > thresholds::least_delay_bound * dt &&
         std::abs(d.seconds) >= thresholds::least_delay * dt;
}

/// Speeds against the place by what is known better.
std::vector<measured::PairDelay> delays_between(const measured::Session& session, double dt, SpeedsBy by) {
  std::vector<measured::PairDelay> delays = measured::pairwise_delays(session);
  if (by == SpeedsBy::accelerations) return delays;
  const auto of = [&](std::string_view channel) {
    return std::ranges::find_if(delays, [channel](const auto& d) { return d.of_clock && d.channel == channel; });
  };
  const auto rate = of("yaw_rate");
  const bool late = rate != delays.end() && rate->seconds < 0.0 && is_significant(*rate, dt);
  const auto finer = measured::displacement_delay(session, late ? -rate->seconds : 0.0);
  const auto speeds = of("velocity");
  if (!finer) return delays;
  if (speeds == delays.end())
    delays.push_back(*finer);
  else if (finer->high - finer->low < speeds->high - speeds->low)
    *speeds = *finer;
  return delays;
}

}  // namespace

std::string ChannelDelay::name() const { return measured::delay_names[group]; }

std::string ChannelDelay::words() const { return words_of(group); }
std::string ChannelDelay::against() const { return words_of(partner[group]); }

std::vector<ChannelDelay> significant_delays(std::span<const LogFile> logs, SpeedsBy speeds) {
  std::vector<ChannelDelay> found;
  const double dt = longest_step(logs);
  for (const measured::PairDelay& d : delays_between(session_of(logs), dt, speeds)) {
    if (!d.of_clock || !is_significant(d, dt)) continue;
    const auto name = std::ranges::find(measured::delay_names, std::string_view(d.channel));
    const auto group = static_cast<std::size_t>(name - measured::delay_names.begin());
    const auto [from, to] = stated_interval(d, dt);
    if (d.seconds > 0.0)
      found.push_back({group, d.seconds, from, to});
    else
      found.push_back({partner[group], -d.seconds, -to, -from});
  }
  std::ranges::sort(found, {}, &ChannelDelay::group);
  join_pose(found);
  return found;
}

void keep_open(std::span<ChannelDelay> delays, std::span<const LogFile> logs, Catalogue& catalogue) {
  catalogue.forget_late_pose();
  const double dt = longest_step(logs);
  const bool one_step = std::ranges::all_of(logs, [dt](const LogFile& file) {
    return std::ranges::all_of(file.stretches, [dt](const Log& log) { return log.dt == dt; });
  });
  for (ChannelDelay& d : delays) {
    if (d.group >= 2) continue;
    d.left = one_step ? d.seconds - dt * std::round(d.seconds / dt) : 0.0;
    catalogue.allow_for_late_pose(d.group, d.left,
                                  std::max(0.5 * (d.high - d.low) / normal_95, thresholds::left_of_delay * dt));
  }
}

bool move_limited(std::span<ChannelDelay> delays, const Catalogue& catalogue, const Fit& fit) {
  bool limited = false;
  for (const LeftOver& one : left_over(catalogue, fit)) limited = limited || one.at_limit;
  if (!limited) return false;
  for (const LeftOver& one : left_over(catalogue, fit))
    for (ChannelDelay& d : delays)
      if (d.group == one.group) d.seconds += one.seconds, d.low += one.seconds, d.high += one.seconds;
  return true;
}

ChannelDelay refined(ChannelDelay delay, const Catalogue& catalogue, const Fit& fit) {
  for (const LeftOver& one : left_over(catalogue, fit)) {
    if (one.group != delay.group) continue;
    delay.seconds += one.seconds;
    // At its limit a fit says nothing of how sure it is.
    delay.low = one.at_limit ? std::min(delay.low, delay.seconds - one.range) : delay.seconds - normal_95 * one.sigma;
    delay.high = one.at_limit ? std::max(delay.high, delay.seconds + one.range) : delay.seconds + normal_95 * one.sigma;
  }
  return delay;
}

bool drop_refuted(std::vector<ChannelDelay>& delays, std::span<const LogFile> logs, const Catalogue& catalogue,
                  const Fit& fit) {
  const double least = thresholds::least_delay * longest_step(logs);
  return std::erase_if(delays, [&](const ChannelDelay& d) { return refined(d, catalogue, fit).seconds < least; }) > 0;
}

LogFile without_delays(const LogFile& file, std::span<const ChannelDelay> delays) {
  LogFile out = file;
  for (Log& log : out.stretches) {
    if (log.size() < 2) continue;
    const std::vector<double> bridged = bridged_readings_of(log);
    for (const ChannelDelay& d : delays)
      for (std::size_t c = 0; c < channels; ++c) {
        if (measured::delay_group[c] != d.group) continue;
        const std::vector<double> rows = read_later(log, bridged, c, d.seconds - d.left);
        for (std::size_t k = 0; k < log.size(); ++k) log.reading[k * channels + c] = rows[k];
      }
  }
  for (const ChannelDelay& d : delays) {
    std::string text = format("%.3g s (%.3g to %.3g) against the ", d.seconds, d.low, d.high) + d.against();
    out.health.push_back({measured::Finding::Level::note, "delay of " + d.name(), std::move(text), "taken off"});
  }
  return out;
}

std::vector<LogFile> without_delays(std::span<const LogFile> logs, std::span<const ChannelDelay> delays) {
  std::vector<LogFile> out;
  out.reserve(logs.size());
  for (const LogFile& log : logs) out.push_back(without_delays(log, delays));
  return out;
}

}  // namespace gripline::diagnose
