// Score tests: would the likelihood rise if a fitted model had further parameters?
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <span>

#include "diagnose/inference/fit.hpp"
#include "diagnose/inference/normal_equations.hpp"
#include "diagnose/model/regressors.hpp"

namespace gripline::diagnose {

/// Score (Lagrange multiplier) test of further parameters at zero, the first `own_params` of a system profiled out.
struct ScoreTest {
  double gain = 0;        // predicted rise of the log likelihood; twice it is a chi-square of dof when all are zero
  std::size_t dof = 0;    // combinations that can be distinguished from the own parameters
  Eigen::VectorXd step;   // predicted values of the further parameters
  Eigen::VectorXd score;  // gradient of the log likelihood by them
  Eigen::MatrixXd information;  // on them
};
/// N, g: normal equations of the own and the further parameters. Combinations of unit regressors with an eigenvalue of
/// less than `rank_tolerance` are left out.
ScoreTest score_test(const Eigen::MatrixXd& N, const Eigen::VectorXd& g, Eigen::Index own_params,
                     double rank_tolerance = thresholds::rank_tolerance_test);

/// Normal equations of a fitted model's own parameters, then of further regressors, for tests of whether anything is
/// left. Nuisances at their limits stay there (screening lets them come back: an effect takes their place, a
/// remainder does not).
struct ScoreSystem {
  NormalEquations normal;
  Eigen::Index own_params = 0;  // how many are the model's own
};
using FurtherRegressors = std::function<std::vector<Regressor>(const Trace&, const LinearModel&)>;
/// `along` is linearise_all of the fitted model.
ScoreSystem score_system(const Problem& problem, const Fit& fitted, std::span<const Linearised> along,
                         const FurtherRegressors& further);

}  // namespace gripline::diagnose
