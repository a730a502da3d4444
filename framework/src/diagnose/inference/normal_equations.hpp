// Normal equations whose first parameters are nuisances with limits.
#pragma once

#include <Eigen/Dense>

#include "diagnose/inference/filter.hpp"
#include "diagnose/model/candidates.hpp"

namespace gripline::diagnose {

/// Of all logs, as far as they were added: cost(theta) ~ cost - g' d + d' N d / 2.
struct NormalEquations {
  Eigen::MatrixXd N;
  Eigen::VectorXd g;

  void add(const Likelihood& l) {
    const auto p = static_cast<Eigen::Index>(l.params);
    if (g.size() == 0) {
      N = Eigen::MatrixXd::Zero(p, p);
      g = Eigen::VectorXd::Zero(p);
    }
    N += Eigen::Map<const Eigen::MatrixXd>(l.N.data(), p, p);
    g += Eigen::Map<const Eigen::VectorXd>(l.g.data(), p);
  }

  /// One parameter is believed to be a number of standard deviations `off` from where it stands.
  void add_belief(Eigen::Index at, double off, double sigma) {
    g[at] -= off / sigma;
    N(at, at) += 1.0 / (sigma * sigma);
  }

  /// What is known of the nuisances beforehand. Returns its cost.
  double add_nuisances(const Catalogue& catalogue, const ModelSpec& model) {
    double cost = 0.0;
    const auto nuisances = catalogue.nuisances();
    for (std::size_t i = 0; i < nuisances.size(); ++i) {
      const double off = (model.nuisance[i] - nuisances[i].nominal) / nuisances[i].sigma;
      add_belief(static_cast<Eigen::Index>(i), off, nuisances[i].sigma);
      cost += 0.5 * off * off;
    }
    return cost;
  }
};

/// Nuisances deviate by at most this many of their standard deviations: what is beyond is a missing effect, not a
/// parameter known badly (framework/doc/diagnose.md, "Parameters that are not known well").
inline constexpr double nuisance_limit = 2.0;

/// Takes a parameter out of the system: its step is `step`, the others see what that does.
inline void hold(NormalEquations& normal, Eigen::Index i, double step) {
  auto& [N, g] = normal;
  g -= N.col(i) * step;
  const double size = N(i, i);
  N.row(i).setZero();
  N.col(i).setZero();
  N(i, i) = size;
  g[i] = 0.0;
}

/// Takes out the nuisances that stand at a limit and would go beyond it.
inline void hold_at_limits(const Catalogue& catalogue, const ModelSpec& model, NormalEquations& normal) {
  const auto nuisances = catalogue.nuisances();
  for (std::size_t i = 0; i < nuisances.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const double off = (model.nuisance[i] - nuisances[i].nominal) / nuisances[i].sigma;
    const bool beyond =
        (off > nuisance_limit - 1e-6 && normal.g[at] > 0.0) || (off < -nuisance_limit + 1e-6 && normal.g[at] < 0.0);
    if (beyond) hold(normal, at, 0.0);
  }
}

}  // namespace gripline::diagnose
