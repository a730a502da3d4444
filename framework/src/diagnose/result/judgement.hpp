// Predictions of data that were not fitted judge a first verdict: effects that make them worse go, and what predicts no
// better than the nominal model is withdrawn.
#pragma once

#include "diagnose/inference/hold_out.hpp"
#include "diagnose/inference/search.hpp"
#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

/// `d`: as conclude() left it, its fit refined along the references of `problem` and its parameters set. Measures the
/// gap and what each named effect does to it; whatever else `d` says is changed where that contradicts it.
/// `delays_taken_off`: whether the logs were put on time. Models without single effects are fitted in the search's pool.
void judge_by_predictions(const HoldOut& hold_out, const Problem& problem, bool delays_taken_off, SearchResult& found,
                          Diagnosis& d);

}  // namespace gripline::diagnose
