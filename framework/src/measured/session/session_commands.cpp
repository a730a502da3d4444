#include "measured/session/session_commands.hpp"

#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "measured/readings/held_readings.hpp"
#include "measured/readings/reading_pace.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

using Level = Finding::Level;
using Command = double CommandSample<double>::*;

BetweenRows between_rows_of(const Session& session, Command command, const std::optional<MappedChannel>& mapped) {
  BetweenRows between = mapped ? mapped->between : BetweenRows{};
  std::vector<double> values;
  for (const CommandSample<double>& c : session.command) values.push_back(c.*command);
  between.repeats = rows_between_new(session.t, values);
  return between;
}

void check_pace(const Session& s, const char* name, Command command, double every, std::vector<Finding>& findings) {
  if (!(every > 0.0)) return;
  ReadingPace pace(every, s.t.front());
  std::vector<double> intervals;
  std::size_t stood = 0, until = 0;  // changes that are taken as they stand, and all of them up to the last of these
  for (std::size_t i = 1; i < s.rows(); ++i) {
    if (s.command[i].*command == s.command[i - 1].*command) continue;
    intervals.push_back(s.t[i] - pace.last());
    pace.change(s.t[i]);
    if (!pace.kept()) ++stood, until = intervals.size();
  }
  if (stood == 0) return;
  const std::string of = std::to_string(stood) + " of " + std::to_string(intervals.size());
  intervals.resize(until);
  findings.push_back({Level::note, name,
                      "changes every " + significant(median(std::move(intervals)), 2) + " s, the map says read every " +
                          significant(every) + " s",
                      of + " changes are taken as they stand in the rows"});
}

}  // namespace

void fill_commands(Session& s, std::span<const double> d, std::span<const double> delta, const LogMap& map,
                   std::vector<Finding>& findings) {
  CommandSample<double> now{0.0, 0.0};
  std::size_t missing = 0;
  for (std::size_t i = 0; i < s.rows(); ++i) {
    const double throttle = d.empty() ? 0.0 : d[i];
    missing += std::isnan(throttle) || std::isnan(delta[i]);
    if (!std::isnan(throttle)) now.d = throttle;
    if (!std::isnan(delta[i])) now.delta = delta[i];
    s.command.push_back(now);
  }
  if (missing > 0)
    findings.push_back({Level::note, "commands", std::to_string(missing) + " rows without", "the last one is held"});
  s.throttle_between = between_rows_of(s, &CommandSample<double>::d, map[Source::d]);
  s.steering_between = between_rows_of(s, &CommandSample<double>::delta, map[Source::delta]);
  s.prescribed_speed = d.empty();
  check_pace(s, "throttle", &CommandSample<double>::d, s.throttle_between.every, findings);
  check_pace(s, "steering", &CommandSample<double>::delta, s.steering_between.every, findings);
}

}  // namespace gripline::measured
