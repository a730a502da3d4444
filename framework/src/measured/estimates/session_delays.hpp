// How late the channels of a session are: against each other, and against what the car does with its commands.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "measured/session/session_file.hpp"

namespace gripline::measured {

/// How much later one channel shows than another what both observe.
struct Delay {
  const char* channel;  // as in the map
  const char* against;
  double seconds = 0;        // positive: `channel` is later
  double low = 0, high = 0;  // 95 % by block bootstrap
  double correlation = 0;    // at that delay
  bool of_clock = true;      // both measure one motion; else the car's own response is in it
  std::size_t blocks = 0;    // drawn from, in which both channels were read; 3 at least
};
/// Yaw rate against heading, speed against place, steering and throttle against what the car does. Only pairs that
/// correlate above 0.5, over three blocks at least in which both were read. Channels that are read in few of the rows
/// are compared at the pace of the sparsest, linear over gaps of at most 0.25 s.
std::vector<Delay> delays_of(const Session& session);
/// Those of a log at its centre of gravity, of channels whose delay the pose tells.
std::vector<Delay> delays_of(const SessionFile& file);
/// Whether a group's channels can be told to be late against the log's pose (velocity against place, yaw rate against
/// yaw). Not where one of the two was derived from the place: such speeds have its noise, half a step late, and a
/// course leads or follows the heading by the car's sideslip, so that no yaw rate is late against it.
bool pose_tells_delay(const SessionFile& file, std::size_t group);

/// Velocity against place by displacements (displacement_lag.hpp), for sessions with x, yaw, vx and vy.
/// `yaw_is_late`: by what the heading is [s].
std::optional<Delay> displacement_delay(const Session& session, double yaw_is_late);

/// Delays of the groups as the map states them, or the pose's own and what was found against it; NaN where nothing
/// tells.
std::array<double, delay_groups> clock_delays(const LogMap& map, const std::vector<Delay>& found);

}  // namespace gripline::measured
