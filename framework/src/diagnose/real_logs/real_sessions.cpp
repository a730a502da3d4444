#include "diagnose/real_logs/real_sessions.hpp"

#include <algorithm>
#include <array>

#include "config/errors.hpp"
#include "measured/gripline_log.hpp"

namespace gripline::diagnose {
namespace {

using measured::SessionFile;
using measured::Source;

bool same_rows(const measured::Session& a, const measured::Session& b) {
  return a.t == b.t && measured::same_readings(a.reading, b.reading) && measured::same_commands(a.command, b.command);
}

void drop_repeated(std::list<SessionFile>& all, const Say& say) {
  for (auto one = all.begin(); one != all.end(); ++one)
    for (auto other = std::next(one); other != all.end();) {
      if (!same_rows(one->session, other->session)) {
        ++other;
        continue;
      }
      say(other->session.name + ": holds the same rows as " + one->session.name + ", used once");
      other = all.erase(other);
    }
}

/// Whether all that gripline's own columns must have is there, to see delays by; a lateral speed may be absent.
bool has_own_columns(const SessionFile& file) {
  return file.has_throttle &&
         std::ranges::all_of(std::array{Source::x, Source::y, Source::yaw, Source::vx, Source::yaw_rate},
                             [&](Source s) { return file.session.has[static_cast<std::size_t>(s)]; });
}

}  // namespace

std::list<SessionFile> read_sessions(const std::vector<std::string>& files, const measured::LogMap& map, double v_ref) {
  std::list<SessionFile> all;
  for (const std::string& file : files) {
    all.push_back(measured::read_session(file, map));
    measured::check_session(all.back(), v_ref);
  }
  return all;
}

void use_once(std::list<SessionFile>& files, std::list<SessionFile>& held_out, const Say& say) {
  drop_repeated(files, say);
  drop_repeated(held_out, say);
  for (const SessionFile& held : held_out)
    for (const SessionFile& file : files)
      if (same_rows(held.session, file.session))
        throw InputError("--held-out " + held.session.name + " holds the same rows as the log " + file.session.name +
                         " that is fitted; expected a log that is not");
}

std::vector<ChannelDelay> channel_delays(const std::list<SessionFile>& files, measured::LogMap map,
                                         const WorldSpec& world, const std::filesystem::path& folder, const Say& say) {
  for (auto& channel : map.channel)
    if (channel && !channel->delay) channel->delay = 0.0;
  std::vector<measured::LogFile> logs;
  for (const SessionFile& file : files) {
    if (!has_own_columns(file)) return {};
    std::string name = std::filesystem::path(file.session.name).stem().string();
    if (!logs.empty()) name += '.' + std::to_string(logs.size() + 1);  // logs of several folders may share a name
    const std::filesystem::path written = folder / (name + ".gripline.csv");
    for (const std::string& remark : measured::write_gripline_log(written, file, map))
      say(file.session.name + ": " + remark);
    logs.push_back(measured::read_log_file(written, {world.car.car.v_ref, nullptr, world.car.car.delta_max}));
  }
  return find_channel_delays(logs);
}

}  // namespace gripline::diagnose
