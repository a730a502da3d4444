// Measured noise beside the noise that a problem assumes: whether it is another, and how that takes it over.
#pragma once

#include "diagnose/inference/fit.hpp"

namespace gripline::diagnose {

/// Noise of the readings and of the motion, as Problem and Fit hold it.
struct MeasuredNoise {
  Noise noise;
  double noise_time = default_noise_time;  // [s]
  Commands bend{};                         // of commands between samples, see measured::bend_commands
  ModelSpec model;                         // the fitted one; where bends are new, its effects' sizes beside them
  double gain = 0;                         // log likelihood over the noise that the measurement began from
};

/// Chooses between noise measured with all unknowns and with fewer: `fewer` where it explains significantly more
/// (thresholds::noise_gain), because `all` then ended on a lower peak of the likelihood.
MeasuredNoise higher_peak(const MeasuredNoise& all, const MeasuredNoise& fewer);

/// Whether measured noise differs from what a problem assumes by more than thresholds::other_noise_factor or
/// thresholds::other_colour.
bool differs_from_assumed(const Problem& problem, const MeasuredNoise& measured);

/// Whether measured noise holds less than what a problem assumes: a colour, a bend or something unknown of the
/// commands is gone, and none has come.
bool is_simpler(const Problem& problem, const MeasuredNoise& measured);

/// Writes measured noise into a problem: what is fitted from then on assumes it. Whether the road is rough under it is
/// not known yet.
void assume(Problem& problem, const MeasuredNoise& measured);

}  // namespace gripline::diagnose
