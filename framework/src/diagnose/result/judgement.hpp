// Predictions of data that were not fitted judge a first explanation: effects that make them worse go, and what
// predicts no better than the nominal model is withdrawn.
#pragma once

#include "diagnose/inference/hold_out.hpp"
#include "diagnose/inference/search.hpp"
#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

struct JudgementOptions {
  bool delays_taken_off = false;  // whether the logs were put on time; such delays are not known exactly
};

/// What stands, with what each named effect does to predictions, and the gap that it closes.
struct Judgement : Explanation, PredictionGaps {};

/// `concluded`: as conclude() says, with its fit refined along references of its own (with_fit()). Models without
/// single effects are fitted in the search's pool, and tested for what they leave along its references.
Judgement judge_by_predictions(SearchResult& found, const HoldOut& hold_out, const JudgementOptions& options,
                               Explanation concluded);

}  // namespace gripline::diagnose
