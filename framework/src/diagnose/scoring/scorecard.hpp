// Tables of scores.
#pragma once

#include <span>
#include <string>

#include "diagnose/scoring/score.hpp"

namespace gripline::diagnose {

/// score.csv: one row per case.
std::string score_csv(std::span<const CaseScore> scores);

/// scorecard.txt: one line per condition (framework/doc/diagnose-cases.md, "Scores").
std::string scorecard(std::span<const CaseScore> scores);

}  // namespace gripline::diagnose
