// Regressors: what a model's own parameters, and those of candidates beside it, change per unit.
#pragma once

#include "diagnose/model/linear_model.hpp"

namespace gripline::diagnose {

/// A model along a trace with the regressors of its own free parameters: nuisances first, then every fitted parameter
/// of the members.
struct Linearised {
  LinearModel lm;
  std::vector<Regressor> own;
  /// Cost of evaluating it per sample, in arbitrary units that no clock enters: the filter's matrices, the integration,
  /// and the memory simulated anew for regressors by difference. The nominal car takes 4 or 5.
  double work = 0;
};
Linearised linearise_with_regressors(const Catalogue& catalogue, const ModelSpec& model, const Trace& trace,
                                     const Stepping& stepping);
/// Without them.
Linearised linearise_alone(const Catalogue& catalogue, const ModelSpec& model, const Trace& trace,
                           const Stepping& stepping);
/// Those regressors alone.
std::vector<Regressor> own_regressors(const Catalogue& catalogue, const ModelSpec& model, const Trace& trace);

/// What one candidate could add to the model: a range of regressors.
struct CandidateRegressors {
  std::size_t candidate = 0;
  std::size_t first = 0, count = 0;         // among the regressors
  std::vector<std::vector<double>> starts;  // scanned candidates: for each regressor all parameters at that start
};

/// Appends the regressors, at neutral values, of every candidate that may be named and is not in the model.
void candidate_regressors(const Catalogue& catalogue, const ModelSpec& model, const Trace& trace,
                          std::vector<Regressor>& regressors, std::vector<CandidateRegressors>& groups);

}  // namespace gripline::diagnose
