#include "diagnose/result/named_delay.hpp"

#include "diagnose/thresholds.hpp"
#include "measured/session/log_map.hpp"

namespace gripline::diagnose {

NamedEffect named_delay(const ChannelDelay& found) {
  NamedEffect delay;
  delay.effect = measured::delay_effect(found.group);
  delay.measurement = true;
  delay.params = {{"T", "s", found.seconds, found.low, found.high}};
  delay.confidence = thresholds::most_confidence;
  return delay;
}

}  // namespace gripline::diagnose
