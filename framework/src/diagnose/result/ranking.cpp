#include "diagnose/result/ranking.hpp"

#include <algorithm>

namespace gripline::diagnose {

std::vector<RankedEffect> ranking_by_evidence(SearchResult& found, const Rivals& rivals) {
  const Problem& problem = found.pool.problem();
  std::vector<RankedEffect> ranking;
  for (const Extension& e : found.pool.screen_once(found.null_model).extensions) {
    RankedEffect row;
    row.effect = problem.catalogue->candidates()[e.candidate].id;
    row.gain =
        found.alone(e.candidate) != nullptr ? found.evidence_alone(e.candidate) : e.gain - problem.penalty(e.dof);
    row.selected_fraction = rivals.bootstrap_of(e.candidate);
    ranking.push_back(std::move(row));
  }
  std::stable_sort(ranking.begin(), ranking.end(),
                   [](const RankedEffect& a, const RankedEffect& b) { return a.gain > b.gain; });
  return ranking;
}

std::vector<RankedEffect> with_predictions(const SearchResult& found, const HoldOut& hold_out,
                                           std::vector<RankedEffect> ranking) {
  const Catalogue& catalogue = *found.pool.problem().catalogue;
  const StartErrors without = hold_out.predict_refitted(found.null_model);
  for (RankedEffect& row : ranking) {
    const Fit* const one = found.alone(catalogue.find(row.effect));
    if (one == nullptr) continue;
    const StartErrors with = hold_out.predict_refitted(*one);
    row.held_out = with.rms();
    row.rollout = compare(with, without);
  }
  std::stable_partition(ranking.begin(), ranking.end(),
                        [](const RankedEffect& row) { return !(row.rollout.change > 0.0); });
  return ranking;
}

}  // namespace gripline::diagnose
