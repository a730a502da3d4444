// Effects added to the calibrated world one after another, while the fitted time asks for them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "diagnose/real_logs/effect_search.hpp"

namespace gripline::diagnose {

struct ForwardSelection {
  Selection found;
  std::vector<ScoredEffect> ranking;  // of every candidate beside the calibrated world alone, by its score
};

/// At each size a score test proposes candidates, and the best few are fitted with everything else. The one that
/// explains the fitted time best among those that lower the errors of the validation time is added, a one-sided curve
/// of the steering together with its offset.
ForwardSelection select_forward(const EffectSearch& search);

/// Goes on beside a selection in the same way, without candidates of these names; an offset still comes with a curve.
void extend_forward(const EffectSearch& search, Selection& selection, std::span<const std::string> without);

}  // namespace gripline::diagnose
