#include "diagnose/inference/predicted_motion.hpp"

namespace gripline::diagnose {

Problem along_predictions(const Problem& problem, const Fit& fitted, std::span<const Linearised> along) {
  FilterOptions options;
  options.predict = true;
  Problem predicted = problem;
  for (std::size_t t = 0; t < along.size(); ++t) {
    const LinearModel& lm = along[t].lm;
    const std::vector<double> off = filter(lm, fitted.noise, options).predicted;
    std::vector<double>& motion = predicted.traces[t].motion;
    for (std::size_t k = 0; k < lm.n; ++k)
      for (std::size_t c = 0; c < channels; ++c) motion[k * channels + c] += off[k * lm.states + c];
  }
  return predicted;
}

bool motion_holds_noise(const Problem& problem, const Noise& noise) {
  return problem.unrounded || problem.command != UnknownCommands{} || has_noticeable_process_noise(problem, noise);
}

std::vector<Linearised> with_own_along(const Problem& predicted, const Fit& fitted, std::span<const Linearised> along) {
  std::vector<Linearised> all(along.begin(), along.end());
  const std::vector<Linearised> own = linearise_all(predicted, fitted.model);
  for (std::size_t t = 0; t < all.size(); ++t) all[t].own = own[t].own;
  return all;
}

}  // namespace gripline::diagnose
