#include "car/effect_order.hpp"

#include <algorithm>

namespace gripline {

EffectOrder order_of(const Effect& effect, const PluginEntry& entry) {
  return {effect.stage(), entry.decl->precedence};
}

std::size_t place_in_chain(const EffectOrder& added, std::span<const EffectOrder> chain) {
  const auto acts_after = [&](const EffectOrder& one) {
    return one.stage == added.stage && one.precedence > added.precedence;
  };
  return static_cast<std::size_t>(std::ranges::find_if(chain, acts_after) - chain.begin());
}

}  // namespace gripline
