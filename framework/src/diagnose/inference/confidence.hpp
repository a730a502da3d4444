// How sure a choice among fitted models is: their log evidence, and how it changes when stretches of the log are drawn
// again with replacement.
#pragma once

#include "diagnose/inference/fit.hpp"

namespace gripline::diagnose {

struct Resampled {
  std::vector<const Fit*> models;  // best score first
  std::vector<double> wins;        // share of resampled logs in which each has the best score
};

/// Blocks of one second are drawn `draws` times; the same seed gives the same numbers.
Resampled resample(const Problem& problem, std::span<const Fit* const> models, int draws = 400);

/// Probability of each model by its score alone, as if all were equally likely before.
std::vector<double> posterior(std::span<const Fit* const> models);

}  // namespace gripline::diagnose
