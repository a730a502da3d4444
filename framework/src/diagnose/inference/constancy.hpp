// Parameter constancy: is what was found the same throughout the log? An effect that stands in for another seldom is:
// its size changes with time, with how fast and how hard the car is driven, or from left turns to right ones.
#pragma once

#include <span>
#include <vector>

#include "diagnose/inference/fit.hpp"
#include "diagnose/inference/residual_test.hpp"
#include "diagnose/model/regressors.hpp"

namespace gripline::diagnose {

/// Focused score tests of every member's contribution times functions of time, of the driving (speed, lateral
/// acceleration), and of the side. Empty for a model without effects. `along` is linearise_all of the model.
std::vector<ResidualTest> constancy(const Problem& problem, const Fit& fitted, std::span<const Linearised> along);

/// For each member of the model the larger statistic of its variation with time and with the side, which would do harm
/// at another time and on the lap the other way round.
std::vector<double> constancy_by_member(const Problem& problem, const Fit& fitted, std::span<const Linearised> along);

}  // namespace gripline::diagnose
