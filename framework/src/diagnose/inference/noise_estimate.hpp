// The noise of a log, measured with a model: level and colour of every sensor, size and correlation time of the unknown
// accelerations.
#pragma once

#include "diagnose/inference/measured_noise.hpp"

namespace gripline::diagnose {

/// What of the noise is estimated beside the variances of the unknown accelerations.
struct NoiseEstimateOptions {
  bool sensors = true;            // levels and colours of the sensors
  bool correlation_time = false;  // of the unknown accelerations; determined by strong ones only
  bool commands = false;          // how commands act between samples: their bend, and what is left unknown of them
  bool begin_white = false;       // from white sensors that scatter as the log does, not from those assumed
};

/// Maximum likelihood by Fisher scoring, the fitted model's parameters fixed. Beside bends, which effects imitate, the
/// parameters of these move too. Of long logs the beginnings count (thresholds::noise_samples); what parameters gain by
/// moving to those without bends is not counted, nor is the move. Colours that are not significant are set to zero.
MeasuredNoise measure_noise(const Problem& problem, const Fit& fitted, const NoiseEstimateOptions& options);

/// Lag-one correlation of the innovations of the worst channel, in standard deviations of that of white ones.
double colour_statistic(const Problem& problem, const Fit& fitted);

/// Score of a tenth of LinearModel::command_variation as unknown between samples, in standard deviations of a score:
/// large where the log asks for more of it.
double unknown_commands_statistic(const Problem& problem, const Fit& fitted);

/// Log likelihood that bent commands are predicted to bring beyond what the effects' parameters would alone, by a score
/// test with the noise fixed. Bends act in every step, so that effects can imitate much of what they explain.
double gain_of_bends(const Problem& problem, const Fit& fitted);

}  // namespace gripline::diagnose
