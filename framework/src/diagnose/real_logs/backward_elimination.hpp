// Effects taken out of a selection again where the others make them superfluous or logs held out contradict them.
#pragma once

#include <vector>

#include "diagnose/real_logs/effect_search.hpp"

namespace gripline::diagnose {

/// Leaves in `selection` what is missed where it is taken out, by validation time and by the logs held out; the offset
/// of a steering whose curve stays also where predictions are better with it, but not significantly. Gives how far
/// predictions improve by each effect left beside the others, the best first. Values are not filled in.
std::vector<MissingEffect> eliminate_backward(const EffectSearch& search, Selection& selection);

}  // namespace gripline::diagnose
