#include "diagnose/inference/evaluation.hpp"

#include "diagnose/inference/predicted_motion.hpp"
#include "diagnose/model/regressors.hpp"

namespace gripline::diagnose {
namespace {

using Eigen::Index;

/// The priors on a model's free parameters: the nuisances' and, where the problem has such, those of the parameters'
/// scales around neutral on effects with many parameters.
std::vector<Prior> priors_of(const Problem& problem, const ModelSpec& model) {
  const Catalogue& catalogue = *problem.catalogue;
  std::vector<Prior> priors = nuisance_priors(catalogue, model);
  if (!problem.shape_prior) return priors;
  auto at = static_cast<Index>(priors.size());
  for (std::size_t i = 0; i < model.members.size(); ++i) {
    const Candidate& c = catalogue.candidates()[model.members[i]];
    for (std::size_t f = 0; f < c.fitted.size(); ++f, ++at) {
      if (c.fitted.size() <= thresholds::full_penalty_parameters) continue;
      const double scale = c.decl(f).scale;
      priors.push_back({at, scale, (model.values[i][c.fitted[f]] - c.decl(f).neutral) / scale});
    }
  }
  return priors;
}

}  // namespace

double cost_of_priors(const Problem& problem, const ModelSpec& model) {
  double sum = 0.0;
  for (const Prior& p : priors_of(problem, model)) sum += p.cost();
  return sum;
}

Evaluation evaluate(const Problem& problem, const ModelSpec& model, const Noise& noise, FitFor purpose) {
  Evaluation e;
  for (const Trace& trace : problem.traces) {
    const auto [lm, regressors, work] = differentiate(problem, model, trace, noise, purpose).linearised;
    e.work += work * static_cast<double>(trace.size());
    std::vector<const Regressor*> list;
    for (const Regressor& r : regressors) list.push_back(&r);
    FilterOptions options;
    options.regressors = &list;
    options.noise_gradient = true;
    const Likelihood l = filter(lm, noise, options);
    e.cost += l.cost;
    e.normal.add(l);
    for (std::size_t i = 0; i < noise_states; ++i) {
      e.noise_gradient[i] += l.noise_gradient[i];
      for (std::size_t j = 0; j < noise_states; ++j)
        e.noise_information(static_cast<Index>(i), static_cast<Index>(j)) += l.noise_information[i][j];
    }
  }
  e.normal.add(priors_of(problem, model));
  e.cost += cost_of_priors(problem, model);
  return e;
}

}  // namespace gripline::diagnose
