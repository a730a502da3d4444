// How sure the choice among fitted models is: by their evidence, and by a block bootstrap of the log.
#pragma once

#include <span>
#include <vector>

#include "diagnose/inference/fit.hpp"

namespace gripline::diagnose {

/// For each model the share of resampled logs in which its evidence is the best. Blocks of one second are drawn with
/// replacement `draws` times; the same numbers each time, for the generator's seed is fixed.
std::vector<double> block_bootstrap(const Problem& problem, std::span<const Fit* const> models,
                                    int draws = thresholds::bootstrap_draws);

/// Posterior probability of each model under equal priors; the best evidence comes first.
std::vector<double> posterior(std::span<const Fit* const> models);

}  // namespace gripline::diagnose
