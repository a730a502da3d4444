// Normal equations whose first parameters are nuisances with limits.
#pragma once

#include <Eigen/Dense>

#include "candidates.hpp"

namespace gripline::diagnose {

/// Nuisances deviate by at most this many of their standard deviations: what is beyond is a missing effect, not a
/// parameter known badly (discrepancy protocol, section 2).
inline constexpr double nuisance_limit = 2.0;

/// Takes a parameter out of the system: its step is `step`, the others see what that does.
inline void hold(Eigen::MatrixXd& N, Eigen::VectorXd& g, Eigen::Index i, double step) {
  g -= N.col(i) * step;
  const double size = N(i, i);
  N.row(i).setZero();
  N.col(i).setZero();
  N(i, i) = size;
  g[i] = 0.0;
}

/// Takes out the nuisances that stand at a limit and would go beyond it.
inline void hold_at_limits(const Catalogue& catalogue, const ModelSpec& model, Eigen::MatrixXd& N, Eigen::VectorXd& g) {
  const auto nuisances = catalogue.nuisances();
  for (std::size_t i = 0; i < nuisances.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const double off = (model.nuisance[i] - nuisances[i].nominal) / nuisances[i].sigma;
    const bool beyond = (off > nuisance_limit - 1e-6 && g[at] > 0.0) || (off < -nuisance_limit + 1e-6 && g[at] < 0.0);
    if (beyond) hold(N, g, at, 0.0);
  }
}

}  // namespace gripline::diagnose
