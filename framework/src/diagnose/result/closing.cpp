#include "diagnose/result/closing.hpp"

#include "diagnose/thresholds.hpp"

namespace gripline::diagnose {

using thresholds::least_closing;

Closing closing(const Gap& gap, double evidence, bool moved) {
  if (gap.after < (1.0 - least_closing) * gap.before && (!moved || gap.closure > 0.0)) return Closing::closes;
  const bool surely_worse = moved ? gap.change.harms() : !(gap.after < (1.0 + least_closing) * gap.before);
  return surely_worse || !(evidence > thresholds::ample_evidence) ? Closing::open : Closing::ask_fitted;
}

bool closes_fitted(const ErrorChange& change, bool moved) {
  return change.change < -least_closing && (!moved || change.helps());
}

}  // namespace gripline::diagnose
