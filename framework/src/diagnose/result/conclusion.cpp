#include "diagnose/result/conclusion.hpp"

#include <algorithm>
#include <span>

#include "diagnose/inference/selection.hpp"
#include "diagnose/result/manoeuvre.hpp"
#include "diagnose/result/ranking.hpp"

namespace gripline::diagnose {
namespace {

std::vector<std::string> ids_of(const ModelSpec& model, const Catalogue& catalogue) {
  std::vector<std::string> list;
  for (const std::size_t m : model.members) list.push_back(catalogue.candidates()[m].id);
  return list;
}

/// The selected model's effects with their confidences.
std::vector<NamedEffect> name_effects(const Problem& problem, const SelectedModel& selected, const Rivals& rivals) {
  std::vector<NamedEffect> named;
  for (const std::size_t member : selected.fit.model.members) {
    const Candidate& candidate = problem.catalogue->candidates()[member];
    NamedEffect one;
    one.effect = candidate.id;
    one.measurement = candidate.effect->stage() == Stage::reading;
    one.confidence = std::min({rivals.bootstrap_of(member), rivals.posterior_of(member), thresholds::most_confidence});
    if (selected.unknown) one.confidence = std::min(one.confidence, thresholds::most_beside_unknown);
    if (place_may_be_time(problem, selected.fit.model, member))
      one.confidence = std::min(one.confidence, thresholds::most_in_one_lap);
    named.push_back(std::move(one));
  }
  return named;
}

/// Sets of effects that explain the log as well as the selected ones, these first; empty when there are no others.
std::vector<std::vector<std::string>> equivalents(std::span<const Fit* const> equals, const Fit& selected,
                                                  const SearchResult& found) {
  const Catalogue& catalogue = *found.pool.problem().catalogue;
  std::vector<std::vector<std::string>> sets;
  if (equals.size() > 1)
    for (const Fit* one : equals) sets.push_back(ids_of(one->model, catalogue));
  // Names for one and the same thing.
  for (const auto& [kept, others] : found.synonyms)
    for (const std::size_t other : others) {
      if (!selected.model.has(kept)) continue;
      std::vector<std::string> same = ids_of(selected.model, catalogue);
      std::replace(same.begin(), same.end(), catalogue.candidates()[kept].id, catalogue.candidates()[other].id);
      if (sets.empty()) sets.push_back(ids_of(selected.model, catalogue));
      sets.push_back(std::move(same));
    }
  return sets;
}

}  // namespace

Conclusion conclude(SearchResult& found, const HoldOut& hold_out) {
  SelectedModel selected = select_model(found, hold_out);
  const Rivals rivals = rivals_of(found, selected.fit);
  const Problem& problem = found.pool.problem();
  std::vector<RankedEffect> ranking = ranking_by_evidence(found, rivals);
  Explanation e;
  e.named = name_effects(problem, selected, rivals);
  if (!selected.unknown && !e.named.empty()) {
    const std::vector<const Fit*> equals = indistinguishable_from(selected.fit, rivals, found, hold_out);
    e.equivalent = equivalents(equals, selected.fit, found);
    if (equals.size() > 1)
      e.manoeuvre = distinguishing_manoeuvre(std::span(e.equivalent).first(equals.size()), *problem.catalogue);
  }
  e.unknown = selected.unknown;
  e.tests = std::move(selected.tests);
  e.fit = std::move(selected.fit);
  return {std::move(e), std::move(ranking)};
}

}  // namespace gripline::diagnose
