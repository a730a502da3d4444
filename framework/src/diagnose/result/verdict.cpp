#include "diagnose/result/verdict.hpp"

#include <utility>

namespace gripline::diagnose {

Verdict verdict_of(const Explanation& explanation, std::span<const NamedEffect> delays) {
  if (explanation.unknown) return Verdict::unknown;
  if (explanation.named.empty() && delays.empty()) return Verdict::nothing_missing;
  return explanation.manoeuvre.empty() ? Verdict::named : Verdict::indistinguishable;
}

Diagnosis assemble(Findings found, std::vector<NamedEffect> delays) {
  const Verdict verdict = verdict_of(found, delays);
  return {std::move(found), verdict, std::move(delays), {}};
}

}  // namespace gripline::diagnose
