// Normal equations whose first parameters are nuisances with limits.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <vector>

#include "diagnose/inference/filter.hpp"
#include "diagnose/model/candidates.hpp"
#include "diagnose/thresholds.hpp"

namespace gripline::diagnose {

/// A normal prior on a free parameter.
struct Prior {
  Eigen::Index at;  // among the free parameters
  double sigma;
  double off;  // standard deviations from its mean
  /// Negative log density up to a constant.
  double cost() const { return 0.5 * off * off; }
};

/// The nuisances' priors.
inline std::vector<Prior> nuisance_priors(const Catalogue& catalogue, const ModelSpec& model) {
  std::vector<Prior> priors;
  for (const Nuisance& n : catalogue.nuisances()) {
    const std::size_t i = priors.size();
    priors.push_back({static_cast<Eigen::Index>(i), n.sigma, (model.nuisance[i] - n.nominal) / n.sigma});
  }
  return priors;
}

/// Second-order model of the cost of the logs added: cost(theta + d) ~ cost(theta) - g' d + d' N d / 2.
struct NormalEquations {
  Eigen::MatrixXd N;
  Eigen::VectorXd g;

  void add(const Likelihood& l) {
    const auto p = static_cast<Eigen::Index>(l.params);
    if (g.size() == 0) {
      N = Eigen::MatrixXd::Zero(p, p);
      g = Eigen::VectorXd::Zero(p);
    }
    if (g.size() != p) throw std::logic_error("logs with other parameters cannot be added");
    N += Eigen::Map<const Eigen::MatrixXd>(l.N.data(), p, p);
    g += Eigen::Map<const Eigen::VectorXd>(l.g.data(), p);
  }

  void add(const std::vector<Prior>& priors) {
    for (const Prior& p : priors) {
      g[p.at] -= p.off / p.sigma;
      N(p.at, p.at) += 1.0 / (p.sigma * p.sigma);
    }
  }
};

/// Fixes the step of one parameter to `step` and moves its effect on the others to their gradient.
inline void fix_parameter(NormalEquations& normal, Eigen::Index i, double step) {
  auto& [N, g] = normal;
  g -= N.col(i) * step;
  const double size = N(i, i);
  N.row(i).setZero();
  N.col(i).setZero();
  N(i, i) = size;
  g[i] = 0.0;
}

/// A nuisance that a step would take beyond its limit, and the step that takes it there.
struct BeyondLimit {
  std::size_t nuisance = 0;
  double step = 0;
};
/// The one that `step` (the nuisances' first) takes farthest, in standard deviations, of those that are not `fixed`.
inline std::optional<BeyondLimit> farthest_beyond(const Catalogue& catalogue, const ModelSpec& model,
                                                  const Eigen::VectorXd& step, const std::vector<bool>& fixed) {
  constexpr double limit = thresholds::nuisance_limit;
  const auto nuisances = catalogue.nuisances();
  std::optional<BeyondLimit> worst;
  double over = 1e-9;
  for (std::size_t i = 0; i < nuisances.size(); ++i) {
    const Nuisance& n = nuisances[i];
    const double off = model.nuisance[i] + step[static_cast<Eigen::Index>(i)] - n.nominal;
    const double beyond = std::abs(off) / n.sigma - limit;
    if (fixed[i] || beyond <= over) continue;
    over = beyond;
    worst = {i, n.nominal + (off > 0.0 ? 1.0 : -1.0) * limit * n.sigma - model.nuisance[i]};
  }
  return worst;
}

/// Fixes the nuisances that stand at their limit (thresholds::nuisance_limit) and would go beyond it. Whether there
/// are such.
inline bool fix_at_limits(const Catalogue& catalogue, const ModelSpec& model, NormalEquations& normal) {
  constexpr double limit = thresholds::nuisance_limit;
  const auto nuisances = catalogue.nuisances();
  bool any = false;
  for (std::size_t i = 0; i < nuisances.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const double off = (model.nuisance[i] - nuisances[i].nominal) / nuisances[i].sigma;
    const bool beyond = (off > limit - 1e-6 && normal.g[at] > 0.0) || (off < -limit + 1e-6 && normal.g[at] < 0.0);
    if (beyond) fix_parameter(normal, at, 0.0);
    any = any || beyond;
  }
  return any;
}

}  // namespace gripline::diagnose
