// Forward screening: for every candidate at once, along one linearisation, how much it would bring beside a fitted
// model, and with what values.
#pragma once

#include <map>

#include "diagnose/inference/fit.hpp"
#include "diagnose/inference/normal_equations.hpp"

namespace gripline::diagnose {

/// A fitted model with one candidate more.
struct Extension {
  std::size_t candidate = 0;
  double gain = 0;  // predicted rise of the log likelihood
  std::size_t dof = 0;
  ModelSpec start;  // the extended model at the predicted values
};
struct Screening {
  std::vector<Extension> extensions;  // best predicted evidence first
  NormalEquations normal;             // of the model's own parameters, then of the groups' regressors
  bool at_limit = false;              // whether nuisances stand at their limits
  double own_gain = 0;                // what the own parameters alone would still gain, where there are such
  std::size_t own_params = 0;         // how many are the model's own
  std::vector<CandidateRegressors> groups;
};
Screening screen(const Problem& problem, const Fit& fitted);

/// The information on one regressor that is left beside the model's own parameters, nuisances within their priors.
double information_beside(const Screening& screening, std::size_t regressor);

/// Pairs of candidates with one parameter each, the largest predicted gain first: two effects that hide each other show
/// little of either alone. Only pairs that fit the filter together (Catalogue::fits_filter).
std::vector<Extension> best_pairs(const Problem& problem, const Fit& fitted, const Screening& screening);

/// Candidates whose single regressors are equal up to a factor are one effect under several names: for the first of
/// each such set, the others.
std::map<std::size_t, std::vector<std::size_t>> synonyms(const Screening& screening);

}  // namespace gripline::diagnose
