// Which parameters of an effect only shape what its other parameters do.
#pragma once

#include <cstddef>
#include <vector>

namespace gripline::diagnose {

struct Candidate;

/// The fitted parameters, by number, that change nothing while all are at their neutral values, as the place of a patch
/// of no depth. The effect is applied to instants of all kinds in place of those of a log: what a log happens not to
/// visit, as a part of the lap or the brakes, makes no shape of a parameter. For effects without memory or delay.
std::vector<std::size_t> shape_parameters(const Candidate& candidate);

}  // namespace gripline::diagnose
