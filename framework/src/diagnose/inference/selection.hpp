// Which effects of the best model stand: those that are significant, help on hold-out data and are not stand-ins for
// something else; and which other models the data cannot tell from it.
#pragma once

#include <optional>

#include "diagnose/inference/hold_out.hpp"
#include "diagnose/inference/residual_test.hpp"
#include "diagnose/inference/search.hpp"

namespace gripline::diagnose {

struct SelectedModel {
  Fit fit;
  std::vector<ResidualTest> tests;      // of it
  std::optional<ResidualTest> unknown;  // the strongest of them, where something is left that no effect explains
};
/// Reduces the best model found to what stands. Reduced models are fitted in the search's pool.
SelectedModel select_model(SearchResult& found, const HoldOut& hold_out);

/// Models whose evidence is near that of the selected one (which is among them), best first.
struct Rivals {
  std::vector<const Fit*> models;
  std::vector<double> bootstrap;  // share of resampled logs in which each is the best
  std::vector<double> posterior;  // probability under equal priors
  /// Share of resampled logs that an effect is in the best model of, and its posterior probability.
  double bootstrap_of(std::size_t candidate) const;
  double posterior_of(std::size_t candidate) const;
};
/// Holds pointers into the pool and to `selected`.
Rivals rivals_of(const SearchResult& found, const Fit& selected);

/// The selected model and the fewest others that together hold the truth with probability thresholds::set_coverage; one
/// element when it leads by thresholds::equal_evidence. Models that contain the selected one, or an effect that may be
/// nothing, say nothing else and are left out.
std::vector<const Fit*> indistinguishable_from(const Fit& selected, const Rivals& rivals, const SearchResult& found,
                                               const HoldOut& hold_out);

/// Whether an effect of place was passed too seldom (below thresholds::laps_to_tell_place_from_time) to tell its place
/// from that time.
bool place_may_be_time(const Problem& problem, const ModelSpec& model, std::size_t candidate);

}  // namespace gripline::diagnose
