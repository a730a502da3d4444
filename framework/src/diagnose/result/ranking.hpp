// Every candidate alone: what the log says for it, and predictions of data that were not fitted.
#pragma once

#include <vector>

#include "diagnose/inference/selection.hpp"
#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

/// Candidates by their evidence, best first: fitted where that was tried, else as predicted by the score test.
std::vector<RankedEffect> ranking_by_evidence(SearchResult& found, const Rivals& rivals);

/// The ranking with what each one that was tried does to predictions, refitted without the data held out: a refit of
/// each. Those that raise the error go behind all others.
std::vector<RankedEffect> with_predictions(const SearchResult& found, const HoldOut& hold_out,
                                           std::vector<RankedEffect> ranking);

}  // namespace gripline::diagnose
