#include "diagnose/real_logs/real_sessions.hpp"

#include <algorithm>
#include <array>

#include "config/errors.hpp"
#include "measured/estimates/session_delays.hpp"
#include "measured/session/centre_of_gravity.hpp"
#include "measured/session/session_checks.hpp"
#include "util/numbers.hpp"

namespace gripline::diagnose {
namespace {

using measured::SessionFile;

bool same_rows(const measured::Session& a, const measured::Session& b) {
  return a.t == b.t && measured::same_readings(a.reading, b.reading) && measured::same_commands(a.command, b.command);
}

void drop_repeated(std::list<SessionFile>& all, const PrintLine& print) {
  for (auto one = all.begin(); one != all.end(); ++one)
    for (auto other = std::next(one); other != all.end();) {
      if (!same_rows(one->session, other->session)) {
        ++other;
        continue;
      }
      print(other->session.name + ": holds the same rows as " + one->session.name + ", used once");
      other = all.erase(other);
    }
}

/// Of a log that is compared together with others: channels whose delay its pose does not identify are as if not read.
void forget_unidentified(measured::LogFile& log, const SessionFile& file) {
  for (std::size_t c = 0; c < measured::channels; ++c) {
    if (measured::pose_identifies_delay(file, measured::delay_group[c])) continue;
    for (measured::Log& stretch : log.stretches)
      for (std::size_t i = 0; i < stretch.size(); ++i) stretch.reading[i * measured::channels + c] = not_a_number;
  }
}

}  // namespace

std::list<SessionFile> read_sessions(const std::vector<std::string>& files, const measured::LogMap& map,
                                     const Car& car) {
  std::list<SessionFile> all;
  for (const std::string& file : files) {
    all.push_back(measured::read_session(file, map));
    measured::check_session(all.back(), car.v_ref, car.delta_max);
  }
  return all;
}

void use_once(std::list<SessionFile>& files, std::list<SessionFile>& held_out, const PrintLine& print) {
  drop_repeated(files, print);
  drop_repeated(held_out, print);
  for (const SessionFile& held : held_out)
    for (const SessionFile& file : files)
      if (same_rows(held.session, file.session))
        throw InputError("--held-out " + held.session.name + " holds the same rows as the log " + file.session.name +
                         " that is fitted; expected a log that is not");
}

std::vector<ChannelDelay> significant_delays_beyond_map(const std::list<SessionFile>& files,
                                                        const measured::LogMap& map, double v_ref) {
  std::array<double, measured::delay_groups> stated{};
  for (std::size_t g = 0; g < stated.size(); ++g) stated[g] = map.delay(g).value_or(0.0);
  std::vector<measured::LogFile> logs;
  for (const SessionFile& file : files) {
    logs.push_back(measured::on_even_grid(measured::at_centre_of_gravity(file, stated), v_ref));
    forget_unidentified(logs.back(), file);
  }
  return significant_delays(logs, SpeedsBy::accelerations);
}

measured::LogMap with_found(measured::LogMap map, std::span<const ChannelDelay> delays) {
  constexpr std::size_t position = 0, yaw = 1, velocity = 2;
  const auto leave_open = [&](std::size_t group, double seconds) {
    if (const auto stated = map.delay(group)) map.find_delay(group, *stated + seconds);
  };
  for (const ChannelDelay& one : delays) leave_open(one.group, one.seconds);
  for (const ChannelDelay& one : delays)
    if (one.group == yaw)
      for (const std::size_t other : {position, velocity})
        if (std::ranges::find(delays, other, &ChannelDelay::group) == delays.end()) leave_open(other, one.seconds);
  return map;
}

}  // namespace gripline::diagnose
