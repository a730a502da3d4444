#include "measured/gripline_log.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "measured/bridged_readings.hpp"
#include "measured/session_health.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"
#include "util/whole_file.hpp"

namespace gripline::measured {
namespace {

void append(std::string& line, double value, int digits) {
  line += ',';
  if (std::isnan(value)) return;
  char buffer[64];
  const auto [end, code] = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, digits);
  if (code == std::errc()) line.append(buffer, end);
}

/// The centre of gravity's reading behind the row's. `heading`: its yaw, also where the row has none.
void remove_frames(Channels& r, double heading, const Frame& pose, const Frame& velocity) {
  r[Channel::yaw] -= pose.yaw;
  if (pose.x != 0.0 || pose.y != 0.0) {  // else a place needs no heading
    const double c = std::cos(heading - pose.yaw), s = std::sin(heading - pose.yaw);
    r[Channel::x] -= pose.x * c - pose.y * s;
    r[Channel::y] -= pose.x * s + pose.y * c;
  }
  const double cv = std::cos(velocity.yaw), sv = std::sin(velocity.yaw);
  const double vx = r[Channel::vx] * cv - r[Channel::vy] * sv, vy = r[Channel::vy] * cv + r[Channel::vx] * sv;
  const bool turned = velocity.yaw != 0.0 && !std::isnan(r[Channel::vy]);
  if (turned) r[Channel::vx] = vx, r[Channel::vy] = vy;
  if ((velocity.x != 0.0 || velocity.y != 0.0) && !std::isnan(r[Channel::yaw_rate])) {
    r[Channel::vx] += velocity.y * r[Channel::yaw_rate];
    r[Channel::vy] -= velocity.x * r[Channel::yaw_rate];
  }
}

/// A channel's reading at a time between rows, if the nearer of them has one. `bridged`: the session with readings in
/// the rows between.
double moved_reading(const Session& session, const Session& bridged, std::size_t channel, double time) {
  const std::size_t row = session.row_before(time);
  if (row + 1 >= session.rows()) return bridged.interpolate(channel, time);
  const std::size_t nearer = session.t[row + 1] - time < time - session.t[row] ? row + 1 : row;
  return std::isnan(session.at(nearer, channel)) ? not_a_number : bridged.interpolate(channel, time);
}

}  // namespace

Session at_centre_of_gravity(const SessionFile& file, const std::array<double, delay_groups>& delays) {
  const Session& s = file.session;
  const bool on_time = std::ranges::all_of(delays, [](double delay) { return delay == 0.0; });
  if (on_time && !file.pose.given() && !file.velocity.given()) return s;
  Session bridged = s, out = s;
  bridged.reading = bridged_readings(s.t, s.reading, even_motion);
  for (std::size_t i = 0; i < s.rows(); ++i) {
    Channels r{};
    for (std::size_t c = 0; c < channels; ++c) {
      const double delay = delays[delay_group[c]];
      r[c] = delay == 0.0 ? s.at(i, c) : moved_reading(s, bridged, c, s.t[i] + delay);
    }
    remove_frames(r, bridged.interpolate(Channel::yaw, s.t[i] + delays[delay_group[Channel::yaw]]), file.pose,
                  file.velocity);
    std::ranges::copy(r, out.reading.begin() + static_cast<std::ptrdiff_t>(i * channels));
  }
  return out;
}

double typical_speed(const Session& session) {
  std::vector<double> speeds;
  for (std::size_t i = 1; i < session.rows(); ++i) {
    double v = session.at(i, Channel::vx);
    if (std::isnan(v))
      v = std::hypot(session.at(i, Channel::x) - session.at(i - 1, Channel::x),
                     session.at(i, Channel::y) - session.at(i - 1, Channel::y)) /
          (session.t[i] - session.t[i - 1]);
    if (std::isfinite(v)) speeds.push_back(std::abs(v));
  }
  if (speeds.empty()) return 1.0;
  return std::max(lower_quantile(std::move(speeds), 0.75), 0.1);
}

std::vector<std::string> write_gripline_log(const std::filesystem::path& file, const SessionFile& from,
                                            const LogMap& map) {
  constexpr std::array<int, channels> digits = {6, 6, 7, 6, 6, 7};
  const Session& s = from.session;
  std::vector<std::string> done;
  constexpr double least = 1e-3;  // [s] shorter delays are none
  const bool search = std::any_of(map.channel.begin(), map.channel.end(), [](const auto& c) { return c && !c->delay; });
  std::array<double, delay_groups> delays =
      clock_delays(map, search ? delays_of(at_centre_of_gravity(from)) : std::vector<Delay>{});
  for (std::size_t g = 0; g < delay_groups; ++g) {
    if (std::isnan(delays[g])) {
      done.push_back(std::string(delay_names[g]) + ": no delay could be found; none is taken off");
      delays[g] = 0.0;
    } else if (std::abs(delays[g]) < least) {
      delays[g] = 0.0;
    } else {
      done.push_back(std::string(delay_names[g]) + ": " + significant(delays[g]) + " s taken off");
    }
  }
  std::string out = "t_s";
  for (std::size_t c = 0; c < channels; ++c)
    if (s.has[c]) out += std::string(",") + source_info(static_cast<Source>(c)).column;
  out += from.has_throttle ? ",d,delta_rad\n" : ",delta_rad\n";
  const Session own = at_centre_of_gravity(from, delays);
  for (std::size_t i = 0; i < s.rows(); ++i) {
    std::string line;
    append(line, s.begin + s.t[i], 6);
    out.append(line, 1);
    for (std::size_t c = 0; c < channels; ++c) {
      line.clear();
      append(line, own.at(i, c), digits[c]);
      if (s.has[c]) out += line;
    }
    line.clear();
    if (from.has_throttle) append(line, s.command[i].d, 6);
    append(line, s.command[i].delta, 7);
    out += line + '\n';
  }
  write_file(file, out);
  return done;
}

}  // namespace gripline::measured
