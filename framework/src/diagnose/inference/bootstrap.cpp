#include "diagnose/inference/bootstrap.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "diagnose/inference/evaluation.hpp"

namespace gripline::diagnose {
namespace {

/// Negative log likelihood of each second of all logs.
std::vector<double> cost_by_second(const Problem& problem, const Fit& fitted) {
  std::vector<double> cost;
  const StagedCar car = problem.catalogue->build(fitted.model);
  for (const Trace& trace : problem.traces) {
    FilterOptions options;
    options.block = static_cast<std::size_t>(std::max(1.0, std::round(1.0 / trace.log.dt)));
    const Likelihood l = filter(linearise(car, trace, problem.stepping()), fitted.noise, options);
    cost.insert(cost.end(), l.block_cost.begin(), l.block_cost.end());
  }
  return cost;
}

}  // namespace

std::vector<double> block_bootstrap(const Problem& problem, std::span<const Fit* const> models, int draws) {
  std::vector<double> wins(models.size(), 0.0);
  std::vector<std::vector<double>> cost;
  std::vector<double> without_logs;  // what the evidence of each holds beside the logs
  for (const Fit* model : models) {
    cost.push_back(cost_by_second(problem, *model));
    without_logs.push_back(-model->penalty - cost_of_priors(problem, model->model));
  }
  if (models.empty() || cost.front().empty()) return wins;
  std::mt19937_64 random(20240607);
  const std::size_t blocks = cost.front().size();
  std::vector<double> evidence(models.size());
  for (int draw = 0; draw < draws; ++draw) {
    for (std::size_t i = 0; i < models.size(); ++i) evidence[i] = without_logs[i];
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::size_t pick = random() % blocks;
      for (std::size_t i = 0; i < models.size(); ++i) evidence[i] -= cost[i][pick];
    }
    wins[static_cast<std::size_t>(std::max_element(evidence.begin(), evidence.end()) - evidence.begin())] +=
        1.0 / draws;
  }
  return wins;
}

std::vector<double> posterior(std::span<const Fit* const> models) {
  std::vector<double> p;
  double sum = 0.0;
  for (const Fit* one : models) {
    p.push_back(std::exp(one->evidence - models.front()->evidence));
    sum += p.back();
  }
  for (double& x : p) x /= sum;
  return p;
}

}  // namespace gripline::diagnose
