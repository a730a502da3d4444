#include "diagnose/result/channel_error.hpp"

#include "diagnose/thresholds.hpp"

namespace gripline::diagnose {

std::optional<ChannelError> wrong_channel(const Problem& problem, const measured::Channels& stated) {
  std::optional<ChannelError> worst;
  for (std::size_t c = 0; c < measured::channels; ++c) {
    const ChannelError one{c, problem.sensor[c], stated[c]};
    if (!(stated[c] > 0.0) || !(problem.colour[c] > thresholds::slow_colour)) continue;
    if (one.ratio() > (worst ? worst->ratio() : thresholds::wrong_channel)) worst = one;
  }
  return worst;
}

}  // namespace gripline::diagnose
