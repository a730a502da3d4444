// Which effects are missing: a search over sets of candidates by penalised likelihood (Schwarz's criterion). Forward
// steps with a beam, pairs that hide each other, backward steps and exchanges; then once more along the reference that
// the best model smooths.
#pragma once

#include "diagnose/inference/model_pool.hpp"
#include "util/progress.hpp"

namespace gripline::diagnose {

struct SearchOptions {
  /// Work for each minute of log (at least one), after which the search ends with what it has.
  double work_per_minute = thresholds::work_per_minute;
  ProgressCallback progress;  // how much of the search is done, in quarters; may be empty
};

/// What a search found. The pool holds every model tried along the last reference, and the problem as the search left
/// it: references smoothed with the best model, the penalty of strong process noise where there is some.
struct SearchResult {
  ModelPool pool;
  Fit null_model;  // no effect, nuisances fitted
  Fit best;
  /// The best is the largest model allowed, and needs another effect: what is missing is not in the catalogue.
  bool exhausted = false;
  /// Candidates left out because another does exactly the same: (kept, left out).
  std::map<std::size_t, std::vector<std::size_t>> synonyms = {};
  /// Models of at most one effect along the first reference, by members; empty when that was the last.
  std::map<std::vector<std::size_t>, Fit> first_reference = {};

  /// The fit with one effect alone; null when that was not tried.
  const Fit* alone(std::size_t candidate) const;
  /// By how much one effect alone raises the log evidence over the null model, along the same reference. The effect
  /// must have been tried.
  double evidence_alone(std::size_t candidate) const;
};

/// The reference that models are compared along: the search's first, or one that was smoothed with effects.
enum class SearchReference { first, refined };

/// Evidence that the last effect of a model of this size must bring, where the model without it has `over_null` more than
/// the null model. What a model without it needs to be left behind, over_null plus this, rises with over_null, so that
/// a search that goes by it cannot come back to where it was.
double required_evidence(std::size_t size, double over_null, SearchReference along);

SearchResult search_effects(Problem problem, const Road& road, const SearchOptions& options = {});

}  // namespace gripline::diagnose
