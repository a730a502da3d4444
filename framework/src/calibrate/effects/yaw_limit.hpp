// The offset of the yaw-rate channel: logs that have yaw too show it without the car's model, and fits keep to what
// they show. Left free, it takes up what the model misses in bends, in logs whose yaw rate is right.
#pragma once

#include <list>
#include <optional>
#include <vector>

#include "calibrate/effects/candidate_effects.hpp"
#include "calibrate/fit/fit_starts.hpp"
#include "calibrate/fit/unknowns.hpp"
#include "measured/estimates/yaw_rate_offset.hpp"
#include "measured/session/session_file.hpp"

namespace gripline::calibrate {

/// Whether an effect adds its one parameter to the yaw rate that is shown and does nothing else: found by trying it.
bool offsets_yaw_rate(const PluginEntry& entry, const Effect& effect);

/// What yaw says of the yaw-rate channel of logs, of all of their time or of that outside `held_out`; empty where
/// they do not determine it.
std::optional<measured::YawRateOffset> offset_by_yaw(const std::list<measured::SessionFile>& files);
std::optional<measured::YawRateOffset> offset_by_yaw(std::list<measured::SessionFile> files,
                                                     const HeldOutTimes& held_out);

/// Lets candidates that offset the yaw rate go no farther than to what yaw says, from where they do nothing. `by_yaw`
/// may be nothing: then nothing changes.
void limit_to_yaw(std::span<CandidateEffect> candidates, const std::optional<measured::YawRateOffset>& by_yaw);

/// Lets unknowns of a world that has an effect that offsets the yaw rate go no farther than yaw's own interval of it.
/// Values and priors that lie outside are moved to yaw's own value; a range that leaves all of that out stays as it is.
/// Gives the unknowns whose range that limits, in their order.
std::vector<Unknown> limit_to_yaw(const WorldSpec& world, std::span<const ParameterPlace> places,
                                  const std::optional<measured::YawRateOffset>& by_yaw, std::span<double> values,
                                  std::span<Unknown> unknowns);

}  // namespace gripline::calibrate
