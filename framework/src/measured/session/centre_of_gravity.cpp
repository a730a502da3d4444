#include "measured/session/centre_of_gravity.hpp"

#include <algorithm>
#include <cmath>

#include "measured/readings/bridged_readings.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {
namespace {

/// The centre of gravity's reading behind the row's. `near`: what was read at the same times, also in rows around it.
void remove_frames(Channels& r, const Channels& near, const Frame& pose, const Frame& velocity) {
  r[Channel::yaw] -= pose.yaw;
  if (pose.x != 0.0 || pose.y != 0.0) {  // else a place needs no heading
    const double heading = near[Channel::yaw] - pose.yaw, c = std::cos(heading), s = std::sin(heading);
    r[Channel::x] -= pose.x * c - pose.y * s;
    r[Channel::y] -= pose.x * s + pose.y * c;
  }
  if (velocity.yaw != 0.0) {
    const double c = std::cos(velocity.yaw), s = std::sin(velocity.yaw);
    const bool alone = std::isnan(near[Channel::vy]);  // then the car is taken to move straight ahead
    constexpr double sideways = 0.1;                   // such a unit's vx hardly shows that
    if (alone)
      r[Channel::vx] = std::abs(c) > sideways ? r[Channel::vx] / c : not_a_number;
    else
      r[Channel::vx] = r[Channel::vx] * c - near[Channel::vy] * s;
    r[Channel::vy] = r[Channel::vy] * c + near[Channel::vx] * s;
  }
  if ((velocity.x != 0.0 || velocity.y != 0.0) && !std::isnan(near[Channel::yaw_rate])) {
    r[Channel::vx] += velocity.y * near[Channel::yaw_rate];
    r[Channel::vy] -= velocity.x * near[Channel::yaw_rate];
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
  if (on_time && !s.pose.given() && !s.velocity.given()) return s;
  Session bridged = s, out = s;
  out.pose = out.velocity = {};
  bridged.reading = bridged_readings(s.t, s.reading, even_motion);
  for (std::size_t i = 0; i < s.rows(); ++i) {
    Channels r{}, near{};
    for (std::size_t c = 0; c < channels; ++c) {
      const double delay = delays[delay_group[c]];
      r[c] = delay == 0.0 ? s.at(i, c) : moved_reading(s, bridged, c, s.t[i] + delay);
      near[c] = std::isnan(r[c]) ? bridged.interpolate(c, s.t[i] + delay) : r[c];
    }
    remove_frames(r, near, s.pose, s.velocity);
    std::ranges::copy(r, out.reading.begin() + static_cast<std::ptrdiff_t>(i * channels));
  }
  return out;
}

}  // namespace gripline::measured
