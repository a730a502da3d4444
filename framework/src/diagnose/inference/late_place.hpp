// A place that is shown late looks like one that is measured behind the centre of gravity: at one speed they are the
// same. Where the speed changes, a fit of either tells them apart.
#pragma once

#include <optional>
#include <span>

#include "diagnose/inference/channel_delays.hpp"

namespace gripline::diagnose {

/// The delay of the place that is to the log's mean speed what a fitted `pose_lever` says, known to a quarter. None
/// where the model has no such effect, where that lies ahead of the centre of gravity, where the delay would be shorter
/// than thresholds::least_delay samples or beyond longest_late_place, and where no speed was read.
std::optional<ChannelDelay> delay_for_lever(const Catalogue& catalogue, const Fit& found,
                                            std::span<const LogFile> logs);

/// A model found, without its `pose_lever`, at the delays that are now open in the catalogue (keep_open).
ModelSpec with_delays_for_lever(const Catalogue& catalogue, const ModelSpec& found);

}  // namespace gripline::diagnose
