#include "diagnose/result/closing.hpp"

#include "diagnose/thresholds.hpp"

namespace gripline::diagnose {

using thresholds::least_closing;

Closing closing(const Gap& gap, double evidence, bool noisy) {
  if (gap.after < (1.0 - least_closing) * gap.before && (!noisy || gap.closure > 0.0)) return Closing::closes;
  const bool significantly_worse = noisy ? gap.change.harms() : !(gap.after < (1.0 + least_closing) * gap.before);
  return significantly_worse || !(evidence > thresholds::ample_evidence) ? Closing::remains_open
                                                                         : Closing::inconclusive;
}

bool closes_on_training(const ErrorChange& change, bool noisy) {
  return change.change < -least_closing && (!noisy || change.helps());
}

}  // namespace gripline::diagnose
