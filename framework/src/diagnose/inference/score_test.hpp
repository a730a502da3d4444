// Score test of directions that a fitted model does not have: would the likelihood rise with them in?
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <span>

#include "diagnose/inference/fit.hpp"
#include "diagnose/inference/normal_equations.hpp"

namespace gripline::diagnose {

/// Conditional score test of the last directions given the first `own`. Combinations of unit directions of which less
/// than `smallest` is left beside the others are left out.
struct Score {
  double gain = 0;  // predicted rise of the log likelihood
  std::size_t dof = 0;
  Eigen::VectorXd step, score;
  Eigen::MatrixXd information;
};
Score score_test(const Eigen::MatrixXd& N, const Eigen::VectorXd& g, Eigen::Index own, double smallest = 1e-5);

/// Normal equations of a fitted model's own parameters, then of further directions.
struct ScoreSystem {
  NormalEquations normal;
  Eigen::Index own = 0;
};
using FurtherDirections = std::function<std::vector<Direction>(const Trace&, const LinearModel&)>;
/// `along` is linearise_all of the fitted model.
ScoreSystem score_system(const Problem& problem, const Fit& fitted, std::span<const Linearised> along,
                         const FurtherDirections& further);

/// A chi-square as a standard normal (Wilson and Hilferty 1931).
double as_normal(double chi_square, double dof);

}  // namespace gripline::diagnose
