// Channels that contradict each other in a way that no effect of the catalogue explains: noise that is measured with
// the model takes it up, however large it is, as slow noise of one of them, not always of the one that is wrong.
#pragma once

#include <optional>

#include "diagnose/inference/problem.hpp"

namespace gripline::diagnose {

/// Errors of a channel beside its noise as it is stated.
struct ChannelError {
  std::size_t channel = 0;
  double size = 0;    // standard deviation, measured with the model, in the channel's unit
  double stated = 0;  // the noise that the world or the user states
  double ratio() const { return size / stated; }
};

/// The channel whose slow errors (thresholds::slow_colour) are largest over their stated noise; empty where none is
/// more than thresholds::wrong_channel times as large. A channel without a stated noise is not asked.
std::optional<ChannelError> wrong_channel(const Problem& problem, const measured::Channels& stated);

}  // namespace gripline::diagnose
