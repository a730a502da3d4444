#include "diagnose/inference/reference.hpp"

#include <cmath>

namespace gripline::diagnose {

double smooth_reference(Problem& problem, const Road& road, const Fit& fitted) {
  const StagedCar car = problem.catalogue->build(fitted.model);
  double moved = 0.0, rows = 0.0;
  for (Trace& trace : problem.traces) {
    const LinearModel lm = linearise(car, trace, problem.stepping());
    FilterOptions options;
    options.smooth = true;
    const Likelihood l = filter(lm, fitted.noise, options);
    std::vector<double> motion = trace.motion;
    for (std::size_t k = 0; k < trace.size(); ++k)
      for (std::size_t c = 0; c < channels; ++c) {
        const double by = l.smoothed[k * lm.states + c];
        motion[k * channels + c] += by;
        moved += std::pow(by / problem.sensor[c], 2);
      }
    rows += static_cast<double>(trace.size() * channels);
    trace.set_motion(std::move(motion), road);
  }
  return std::sqrt(moved / rows);
}

void iterate_reference(Problem& problem, const Road& road, const Fit& fitted) {
  double before = std::numeric_limits<double>::infinity();
  for (int i = 0; i < thresholds::reference_iterations; ++i) {
    const double moved = smooth_reference(problem, road, fitted);
    if (!(moved > thresholds::reference_tolerance) || moved > before) return;
    before = moved;
  }
}

}  // namespace gripline::diagnose
