// How late the channels of a session are. Two quantities: by pair, how much later one channel shows what another shows
// too (`PairDelay`); and by group, how late the channels of one clock are on the log's own clock (`delay_groups`),
// which follows from the pairs for what the map does not state. A fit starts its search for delays by group there
// (calibrate/fit), `import` takes off those that are told from 0 (`delays_to_take_off`);
// diagnose/inference/channel_delays decides which pairs are significant.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "measured/session/session_file.hpp"

namespace gripline::measured {

/// How much later one channel of a pair shows what both observe.
struct PairDelay {
  const char* channel;  // as in the map
  const char* against;
  double seconds = 0;        // positive: `channel` is later
  double low = 0, high = 0;  // 95 % by block bootstrap
  double correlation = 0;    // at that delay
  bool of_clock = true;      // both measure one motion; else the car's own response is in it
  std::size_t blocks = 0;    // drawn from, in which both channels were read; 3 at least
};
/// Of each pair of channels: yaw rate against heading, speed against place, steering and throttle against what the car
/// does. Only pairs that correlate above 0.5, over three blocks at least in which both were read. Channels that are
/// read in few of the rows are compared at the pace of the sparsest, linear over gaps of at most 0.25 s.
std::vector<PairDelay> pairwise_delays(const Session& session);
/// The same of a log through its map: at its centre of gravity, and without yaw rate against yaw, or speed against
/// place, where one of the two was derived from the place (pose_identifies_delay).
std::vector<PairDelay> pairwise_delays_of_file(const SessionFile& file);
/// Whether the log's pose identifies the delay of a group's channels (velocity against place, yaw rate against yaw). Not
/// where one of the two was derived from the place: such speeds have its noise, half a step late, and a
/// course leads or follows the heading by the car's sideslip, so that no yaw rate is late against it.
bool pose_identifies_delay(const SessionFile& file, std::size_t group);

/// By how much the place is late against the speeds [s], as their pair shows; 0 where it is not told from that.
double place_lateness(const SessionFile& file);

/// Velocity against place by displacements (displacement_lag.hpp), for sessions with x, yaw, vx and vy.
/// `yaw_is_late`: by what the heading is [s].
std::optional<PairDelay> displacement_delay(const Session& session, double yaw_is_late);

/// By group, how late it is on the log's clock [s]: as the map states it, else what was found between pairs, `found`,
/// added to how late the pose is. A pose of which nothing is stated counts as on time; NaN where it is not identified.
std::array<double, delay_groups> stated_or_found_delays(const LogMap& map, const std::vector<PairDelay>& found);

/// What `import` takes off a log.
struct DelaysToTakeOff {
  std::array<double, delay_groups> seconds{};  // by group, as write_gripline_log takes them
  std::vector<std::string> remarks;            // a sentence for each delay found that counts as none
};
/// As stated_or_found_delays, whose pairs are compared only where the map leaves a channel's delay to be found. A delay
/// between a pair counts as none where its interval holds 0, and where it is shorter than shortest_delay or a twentieth
/// of what lies between two readings of the channel that is read less often: taken off, it would make a log late that
/// is not. The channel is then as late as what it is compared with.
DelaysToTakeOff delays_to_take_off(const LogMap& map, const SessionFile& file);

}  // namespace gripline::measured
