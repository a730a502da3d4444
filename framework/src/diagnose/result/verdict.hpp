// The verdict on what was found, and the diagnosis that it heads: of simulated logs and of real cars alike.
#pragma once

#include <span>

#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

/// `unknown` where something is left that no effect explains, whatever is named beside it; `nothing_missing` where
/// neither an effect nor a delay is named; `indistinguishable` where a manoeuvre would tell sets of effects apart; else
/// `named`.
Verdict verdict_of(const Explanation& explanation, std::span<const NamedEffect> delays);

/// All but the sentence, whose words depend on how the logs were searched.
Diagnosis assemble(Findings found, std::vector<NamedEffect> delays);

}  // namespace gripline::diagnose
