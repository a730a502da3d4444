// The logs that a diagnosis of a real car is of: read and checked, each of them once, with the delays of their
// channels.
#pragma once

#include <gripline/types.hpp>

#include <functional>
#include <list>
#include <span>
#include <string>
#include <vector>

#include "diagnose/inference/channel_delays.hpp"
#include "measured/session/session_file.hpp"

namespace gripline::diagnose {

using PrintLine = std::function<void(const std::string&)>;

/// `car`: of the world, whose typical speed and largest steering angle the logs are checked by. Throws InputError.
std::list<measured::SessionFile> read_sessions(const std::vector<std::string>& files, const measured::LogMap& map,
                                               const Car& car);

/// Takes out logs that have the same rows as one before them, and prints a line on each. Throws InputError where a log
/// that is held out has the rows of one that is fitted: it cannot judge the fit.
void use_once(std::list<measured::SessionFile>& files, std::list<measured::SessionFile>& held_out,
              const PrintLine& print);

/// Groups that are significantly later than `map` states (significant_delays of the logs on their even grid, without
/// the delays that it states), and by how much. Channels that no log has are not compared, nor those whose delay the
/// pose does not identify (measured::pose_identifies_delay). `v_ref`: typical speed of the car [m/s].
std::vector<ChannelDelay> significant_delays_beyond_map(const std::list<measured::SessionFile>& files,
                                                        const measured::LogMap& map, double v_ref);

/// A map that leaves the delays of the channels that are later than it states to be fitted, from where they were found;
/// where yaw is late, also those of place and speed, which one receiver may give with it.
measured::LogMap with_found(measured::LogMap map, std::span<const ChannelDelay> delays);

}  // namespace gripline::diagnose
