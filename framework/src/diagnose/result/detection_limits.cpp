#include "diagnose/result/detection_limits.hpp"

#include <cmath>

#include "diagnose/thresholds.hpp"
#include "util/numbers.hpp"

namespace gripline::diagnose {

std::vector<DetectionLimit> detection_limits(const Problem& problem, const Screening& beside_null_model) {
  std::vector<DetectionLimit> limits;
  const double needed = 2.0 * (thresholds::single_gain + problem.penalty_per_parameter());
  for (const CandidateRegressors& group : beside_null_model.groups) {
    const Candidate& c = problem.catalogue->candidates()[group.candidate];
    // Of several parameters, or several places, of those that show in this log the one that shows least.
    DetectionLimit limit{c.id, c.decl(c.strength).name, c.decl(c.strength).unit, not_a_number};
    for (std::size_t i = 0; i < group.count; ++i) {
      const abi::ParamDecl& p = c.decl(group.starts.empty() && group.count == c.fitted.size() ? i : c.strength);
      const double information = information_beside(beside_null_model, group.first + i);
      const double size = std::sqrt(needed / information);
      // A log that says nothing of an effect, such as one without braking of the brakes, would have shown none.
      if (!(information > 0.0) || size > p.hi - p.lo || size <= limit.size) continue;
      limit.param = p.name;
      limit.unit = p.unit;
      limit.size = size;
    }
    limits.push_back(std::move(limit));
  }
  return limits;
}

}  // namespace gripline::diagnose
