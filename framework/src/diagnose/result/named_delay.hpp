// A delay of a channel as a result names it.
#pragma once

#include "diagnose/inference/channel_delays.hpp"
#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

/// The delay beside the effects that are named; what taking it off does to predictions is not measured yet.
NamedEffect named_delay(const ChannelDelay& found);

}  // namespace gripline::diagnose
