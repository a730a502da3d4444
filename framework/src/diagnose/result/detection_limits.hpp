// How small an effect a log would still have shown, where nothing was found to be missing.
#pragma once

#include <vector>

#include "diagnose/inference/screening.hpp"
#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

/// For each candidate that was screened beside the null model, the size at which it is predicted to bring as much log
/// evidence as a name needs (thresholds::single_gain).
std::vector<DetectionLimit> detection_limits(const Problem& problem, const Screening& beside_null_model);

}  // namespace gripline::diagnose
