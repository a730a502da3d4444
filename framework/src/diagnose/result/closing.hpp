// Whether what is named closes some of the gap between predictions and measurement.
#pragma once

#include "diagnose/inference/error_change.hpp"
#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

/// What data not fitted say: the gap closes, it remains open, or they are inconclusive and the fitted data decide.
enum class Closing { closes, remains_open, inconclusive };

/// `evidence`: log evidence of what is named over the bare model. `noisy`: noise moves the car between samples (a rough
/// road, commands that are not known there), or delays were taken off that are not known exactly; then the gap must
/// close by more than chance, and effects smaller than such noise are only open where predictions get significantly
/// worse with them. With ample evidence, what rests during the laps held out is inconclusive.
Closing closing(const Gap& gap, double evidence, bool noisy);

/// Whether predictions of fitted data say that the gap closes.
bool closes_on_training(const ErrorChange& change, bool noisy);

}  // namespace gripline::diagnose
