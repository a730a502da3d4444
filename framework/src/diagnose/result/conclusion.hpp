// From a search to a first verdict, by evidence: which effects are missing, how sure that is, and what else would
// explain the log as well. Predictions are asked afterwards (judgement.hpp).
#pragma once

#include "diagnose/inference/hold_out.hpp"
#include "diagnose/inference/search.hpp"
#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

/// Sets verdict, named effects without parameters, equivalent sets with the manoeuvre that would tell them apart,
/// ranking without predictions, tests, what is unknown, and both fits. Reduced models are fitted in the search's pool.
Diagnosis conclude(SearchResult& found, const HoldOut& hold_out);

}  // namespace gripline::diagnose
