#include "measured/health/session_health.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "measured/estimates/session_delays.hpp"
#include "measured/estimates/session_noise.hpp"
#include "measured/estimates/timing_slip.hpp"
#include "measured/readings/held_readings.hpp"
#include "measured/session/centre_of_gravity.hpp"
#include "measured/session/session_warnings.hpp"
#include "measured/session/session_windows.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

using Values = std::vector<double>;
using Level = Finding::Level;

void rate_and_gaps(const SessionFile& file, std::vector<Finding>& out) {
  const Session& s = file.session;
  double shortest = 1e9, longest = 0.0, missing = 0.0;
  std::size_t gaps = 0;
  for (std::size_t i = 1; i < s.rows(); ++i) {
    const double step = s.t[i] - s.t[i - 1];
    shortest = std::min(shortest, step);
    longest = std::max(longest, step);
    if (step > 2.5 * file.row_step) ++gaps, missing += step;
  }
  out.push_back({Level::good, "rate",
                 significant(1.0 / file.row_step) + " Hz over " + significant(s.t.back() - s.t.front(), 4) + " s",
                 "steps of " + significant(1e3 * shortest) + " to " + significant(1e3 * longest) + " ms"});
  if (gaps > 0)
    out.push_back(
        {Level::note, "gaps",
         std::to_string(gaps) + ", " + significant(missing) + " s of them, longest " + significant(longest) + " s",
         "not bridged"});
  const double length = s.t.back() - s.t.front();
  if (length < 20.0)
    out.push_back(
        {Level::note, "length", significant(length) + " s", "little data to identify parameters; 60 s are good"});
}

/// Says which channels repeat their values in step though the map does not say that they are held, and returns them.
std::array<bool, channels> missing_and_held(const SessionFile& file, std::vector<Finding>& out) {
  const Session& s = file.session;
  std::array<bool, channels> held{};
  for (std::size_t c = 0; c < channels; ++c) {
    if (!s.has[c]) continue;
    Values values;
    std::size_t absent = 0;
    for (std::size_t i = 0; i < s.rows(); ++i) {
      values.push_back(s.at(i, c));
      absent += i > 0 && std::isnan(values.back()) ? 1 : 0;
    }
    if (absent > 0)
      out.push_back(
          {Level::note, channel_info[c].name, std::to_string(absent) + " readings missing", "left out, one by one"});
    const double every = rows_between_new(s.t, values);
    held[c] = every > 1.0;
    if (held[c])
      out.push_back({Level::note, channel_info[c].name, "a new value every " + significant(every) + " rows",
                     "read as if each row were new: say \"hold\": \"held\" in the map"});
  }
  return held;
}

/// Commands that repeat in step and are taken for new in each row.
void repeated_commands(const SessionFile& file, std::vector<Finding>& out) {
  const Session& s = file.session;
  const auto look_at = [&](const BetweenRows& between, const char* name) {
    if (between.is_unexplained())
      out.push_back({Level::note, name, "a new value every " + significant(between.repeats) + " rows",
                     "read as linear between rows: say \"hold\": \"held\" in the map"});
  };
  if (!s.prescribed_speed) look_at(s.throttle_between, "d");
  look_at(s.steering_between, "delta");
}

/// Sizes of a channel's second differences from row to row.
Values second_differences(const Session& s, std::size_t c, double row_step) {
  Values second;
  for (std::size_t i = 2; i < s.rows(); ++i) {
    const double d = s.at(i, c) - 2.0 * s.at(i - 1, c) + s.at(i - 2, c);
    if (!std::isnan(d) && s.t[i] - s.t[i - 2] < 3.0 * row_step) second.push_back(std::abs(d));
  }
  return second;
}

/// Jumps of all rows, by the median change while the car moves.
void jumps(const SessionFile& file, const Session& moving, std::vector<Finding>& out) {
  for (std::size_t c = 0; c < channels; ++c) {
    const Values second = second_differences(file.session, c, file.row_step),
                 in_motion = second_differences(moving, c, file.row_step);
    if (in_motion.size() < 100) continue;
    const double typical = median(in_motion);
    const auto far = std::count_if(second.begin(), second.end(), [&](double d) { return d > 60.0 * typical; });
    if (typical > 0.0 && far > 0)
      out.push_back({Level::note, channel_info[c].name,
                     std::to_string(far) + " jumps of more than 60 times its median change in motion",
                     "kept; the fit gives them little weight"});
  }
}

void add_noise(const Noise& noise, std::size_t channel, std::vector<Finding>& out) {
  constexpr double most_telling = 0.9;  // correlation beyond which noise and motion look alike
  const std::string check = std::string("noise of ") + channel_info[channel].name;
  const std::string colour = "lag-one correlation " + significant(noise.colour, 2);
  if (noise.sigma == 0.0 || noise.colour > most_telling)
    out.push_back({Level::good, check, "none separable from motion, " + colour,
                   "simulated, filtered or interpolated at its source"});
  else
    out.push_back({Level::good, check, significant(noise.sigma) + " " + channel_info[channel].unit + ", " + colour,
                   "measured from fourth differences"});
}

}  // namespace

std::vector<Finding> constant_commands(const Session& session) {
  constexpr double least_throttle = 0.02, least_angle = 0.005;  // [1], [rad]: less than drivers and noise make of it
  std::vector<Finding> out;
  const auto look_at = [&](double CommandSample<double>::*command, double least, const char* name, const char* unit,
                           const char* lost) {
    Values values;
    for (const CommandSample<double>& c : session.command) values.push_back(c.*command);
    const double low = lower_quantile(values, 0.01), high = lower_quantile(values, 0.99);
    if (high - low < least)
      out.push_back({Level::bad, name, "stays between " + significant(low) + " and " + significant(high) + unit, lost});
  };
  if (!session.prescribed_speed)
    look_at(&CommandSample<double>::d, least_throttle, "d", "",
            "what throttle and brake do cannot be learned; is it the right column?");
  look_at(&CommandSample<double>::delta, least_angle, "delta", " rad",
          "what steering does cannot be learned, nor tyres; is it the right column?");
  return out;
}

std::vector<Finding> health_of(const SessionFile& file) {
  const Session& s = file.session;
  std::vector<Finding> out = file.findings;
  rate_and_gaps(file, out);
  const std::array<bool, channels> held = missing_and_held(file, out);
  repeated_commands(file, out);
  const Session moving = while_moving(s);
  jumps(file, moving, out);
  for (Finding& finding : constant_commands(s)) out.push_back(std::move(finding));
  for (Finding& finding : consistency_warnings(file, place_lateness)) out.push_back(std::move(finding));
  const Session own = at_centre_of_gravity(file);
  // A value that is written again and again jumps once in its period and has no noise of its own.
  const bool steps = held[Channel::x] || held[Channel::y] || held[Channel::vx];
  if (const auto slip = steps ? std::nullopt : timing_slip(own, file.row_step))
    out.push_back({Level::bad, "position",
                   std::string(slip->travel < 0.0 ? "falls back by " : "jumps ahead by ") +
                       significant(1e3 * std::abs(slip->travel)) + " ms of travel once every " +
                       significant(slip->period) + " s, at " + significant(slip->phase) + " s of each",
                   "kept as it is: predictions of whole periods do not see it, others miss by as much"});
  for (std::size_t c = 0; c < channels; ++c)
    if (const auto noise = s.has[c] && !held[c] ? noise_of(moving, c, file.row_step) : std::nullopt)
      add_noise(*noise, c, out);
  for (const PairDelay& d : pairwise_delays_of_file(file))
    out.push_back(
        {Level::good, std::string("delay of ") + d.channel,
         significant(d.seconds) + " s (" + significant(d.low) + " to " + significant(d.high) + ") against " + d.against,
         d.of_clock ? "correlation " + significant(d.correlation, 2)
                    : "correlation " + significant(d.correlation, 2) + "; the car's own response is in it"});
  return out;
}

}  // namespace gripline::measured
