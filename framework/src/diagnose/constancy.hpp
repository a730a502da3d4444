// Is what was named the same throughout the log? An effect that stands in for another one seldom is: its size drifts
// with time, or with how fast and how hard the car is driven.
#pragma once

#include "adequacy.hpp"

namespace gripline::diagnose {

/// Score tests of every member's contribution times functions of time, and times functions of the driving; focused.
/// Empty for a model without effects. `along` is linearise_all of the model.
std::vector<BasisTest> constancy(const Problem& problem, const Fit& fitted, std::span<const Linearised> along);

/// For each member of the model: the excess of the test that it varies with time.
std::vector<double> drifts(const Problem& problem, const Fit& fitted, std::span<const Linearised> along);

}  // namespace gripline::diagnose
