// Is what was named the same throughout the log? An effect that stands in for another one seldom is: its size drifts
// with time, or with how fast and how hard the car is driven, or it is another in left turns than in right ones.
#pragma once

#include "diagnose/inference/adequacy.hpp"

namespace gripline::diagnose {

/// Score tests of every member's contribution times functions of time, of the driving, and of the side; focused.
/// Empty for a model without effects. `along` is linearise_all of the model.
std::vector<BasisTest> constancy(const Problem& problem, const Fit& fitted, std::span<const Linearised> along);

/// For each member of the model: the largest excess of the tests that it varies with time and with the side. Such a
/// stand-in does harm at another time and on the lap the other way round.
std::vector<double> inconstancy(const Problem& problem, const Fit& fitted, std::span<const Linearised> along);

}  // namespace gripline::diagnose
