#include "diagnose/inference/predicted_motion.hpp"

namespace gripline::diagnose {

Trace along_predictions(const Trace& trace, const LinearModel& model, const Noise& noise) {
  FilterOptions options;
  options.predict = true;
  const std::vector<double> off = filter(model, noise, options).predicted;
  Trace predicted = trace;
  for (std::size_t k = 0; k < model.n; ++k)
    for (std::size_t c = 0; c < channels; ++c) predicted.motion[k * channels + c] += off[k * model.states + c];
  return predicted;
}

Problem along_predictions(const Problem& problem, const Fit& fitted, std::span<const Linearised> along) {
  Problem predicted = problem;
  for (std::size_t t = 0; t < along.size(); ++t)
    predicted.traces[t] = along_predictions(problem.traces[t], along[t].lm, fitted.noise);
  return predicted;
}

bool motion_holds_noise(const Problem& problem, const Noise& noise) {
  return problem.unrounded || problem.command != UnknownCommands{} || has_noticeable_process_noise(problem, noise);
}

std::vector<Linearised> with_own_along(const Problem& predicted, const Fit& fitted, std::span<const Linearised> along) {
  std::vector<Linearised> all(along.begin(), along.end());
  for (std::size_t t = 0; t < all.size(); ++t)
    all[t].own = own_regressors(*predicted.catalogue, fitted.model, predicted.traces[t]);
  return all;
}

Differentiated differentiate(const Problem& problem, const ModelSpec& model, const Trace& trace, const Noise& noise,
                             FitFor purpose) {
  Differentiated out;
  const bool ahead =
      purpose == FitFor::result ? motion_holds_noise(problem, noise) : has_strong_process_noise(problem, noise);
  if (!ahead) {
    out.linearised = linearise_with_regressors(*problem.catalogue, model, trace, problem.stepping());
    return out;
  }
  out.linearised = linearise_alone(*problem.catalogue, model, trace, problem.stepping());
  out.predicted = along_predictions(trace, out.linearised.lm, noise);
  out.linearised.own = own_regressors(*problem.catalogue, model, *out.predicted);
  return out;
}

}  // namespace gripline::diagnose
