// From a search to a first explanation, by evidence: which effects are missing, how sure that is, and what else would
// explain the log as well. Predictions are asked afterwards (judgement.hpp).
#pragma once

#include "diagnose/inference/hold_out.hpp"
#include "diagnose/inference/search.hpp"
#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

/// What is named has no parameters yet, and the ranking no predictions.
struct Conclusion : Explanation {
  std::vector<RankedEffect> ranking;
};

/// Reduced models are fitted in the search's pool.
Conclusion conclude(SearchResult& found, const HoldOut& hold_out);

}  // namespace gripline::diagnose
