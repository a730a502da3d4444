#include "diagnose/inference/confidence.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

namespace gripline::diagnose {

Resampled resample(const Problem& problem, std::span<const Fit* const> models, int draws) {
  Resampled out;
  out.models.assign(models.begin(), models.end());
  out.wins.assign(models.size(), 0.0);
  std::vector<std::vector<double>> cost(models.size());
  for (std::size_t i = 0; i < models.size(); ++i) {
    const StagedCar car = problem.catalogue->build(models[i]->model);
    for (const Trace& trace : problem.traces) {
      FilterWants wants;
      wants.block = static_cast<std::size_t>(std::max(1.0, std::round(1.0 / trace.log.dt)));
      const Likelihood l = filter(linearise(car, trace, problem.substeps), models[i]->noise, wants);
      cost[i].insert(cost[i].end(), l.block_cost.begin(), l.block_cost.end());
    }
  }
  if (models.empty() || cost.front().empty()) return out;
  std::mt19937_64 random(20240607);
  const std::size_t blocks = cost.front().size();
  std::vector<double> score(models.size());
  for (int draw = 0; draw < draws; ++draw) {
    for (std::size_t i = 0; i < models.size(); ++i) score[i] = -models[i]->penalty;
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::size_t pick = random() % blocks;
      for (std::size_t i = 0; i < models.size(); ++i) score[i] -= cost[i][pick];
    }
    out.wins[static_cast<std::size_t>(std::max_element(score.begin(), score.end()) - score.begin())] += 1.0 / draws;
  }
  return out;
}

std::vector<double> posterior(std::span<const Fit* const> models) {
  std::vector<double> p;
  double sum = 0.0;
  for (const Fit* one : models) {
    p.push_back(std::exp(one->score - models.front()->score));
    sum += p.back();
  }
  for (double& x : p) x /= sum;
  return p;
}

}  // namespace gripline::diagnose
