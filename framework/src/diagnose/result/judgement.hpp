// Predictions of data that were not fitted judge a first verdict: effects that make them worse go, and what predicts no
// better than the nominal model is withdrawn.
#pragma once

#include "diagnose/inference/hold_out.hpp"
#include "diagnose/inference/search.hpp"
#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

struct JudgementOptions {
  bool delays_taken_off = false;  // whether the logs were put on time; such delays are not known exactly
};

/// `d`: as conclude() left it, its fit refined along references of its own and its parameters set. Measures the gap and
/// what each named effect does to it; whatever else `d` says is changed where that contradicts it. Models without
/// single effects are fitted in the search's pool, and tested for what they leave along its references.
void judge_by_predictions(SearchResult& found, const HoldOut& hold_out, const JudgementOptions& options, Diagnosis& d);

}  // namespace gripline::diagnose
