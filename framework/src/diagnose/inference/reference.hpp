// The trajectory that models are linearised along: smoothed anew with a fitted model, as in an iterated Kalman
// smoother.
#pragma once

#include "diagnose/inference/fit.hpp"

namespace gripline::diagnose {

/// Replaces the traces' references by the trajectories smoothed with a fitted model. Returns how far they moved: root
/// mean square in sensor standard deviations.
double smooth_reference(Problem& problem, const Road& road, const Fit& fitted);
/// Smooths the traces' references with a model until they converge: a channel without readings starts far off.
void iterate_reference(Problem& problem, const Road& road, const Fit& fitted);

}  // namespace gripline::diagnose
