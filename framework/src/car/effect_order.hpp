// Where an effect that is added to a car acts among those that it has.
#pragma once

#include <cstddef>
#include <span>

#include <gripline/types.hpp>

#include "plugin/registry.hpp"

namespace gripline {

/// What decides it.
struct EffectOrder {
  Stage stage;
  int precedence;  // among effects of one stage: lower acts first
};
EffectOrder order_of(const Effect& effect, const PluginEntry& entry);

/// Index in a chain of effects, in the order in which they act within a stage, at which one more is to be inserted:
/// before the first of its stage that has a higher precedence, else at the end.
std::size_t place_in_chain(const EffectOrder& added, std::span<const EffectOrder> chain);

}  // namespace gripline
