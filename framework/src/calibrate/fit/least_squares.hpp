// Robust nonlinear least squares with priors and bounds, by the method of Levenberg and Marquardt.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "calibrate/fit/prediction_errors.hpp"
#include "util/numbers.hpp"

namespace gripline::calibrate {

struct FitStep {
  int iteration = 0;
  double before = 0, after = 0;  // cost
};

struct LeastSquaresOptions {
  int iterations = 20;
  double tolerance = 3e-4;             // relative decrease of the cost below which it ends
  double initial_cost = not_a_number;  // of the parameters it begins with; NaN: not known
  std::function<void(const FitStep&)> progress;
};

/// Sum of the unknowns' squared distances from their priors, in standard deviations; what their moves add to the normal
/// equations goes to `hessian` and `gradient` where given.
double prior_cost(std::span<const double> params, std::span<const Unknown> unknowns, Eigen::MatrixXd* hessian = nullptr,
                  Eigen::VectorXd* gradient = nullptr);

/// Where unknowns stand after moving by `move` in their own units, kept inside their bounds.
std::vector<double> after_step(std::span<const double> params, std::span<const Unknown> unknowns,
                               const Eigen::VectorXd& move);

/// Minimises errors.cost + prior_cost from `params`; gives the parameters found and, in `cost`, what is left.
std::vector<double> least_squares(const PredictionErrors& errors, std::span<const Unknown> unknowns,
                                  std::vector<double> params, const LeastSquaresOptions& options, double& cost);

/// What the logs say of an unknown. Low and high enclose 95 %.
struct Interval {
  double low = 0, high = 0;
  double sigma = 0;    // of the move, in the unknown's own units
  double learned = 0;  // 1 - posterior / prior variance: 0 where the logs say nothing
};

/// Block bootstrap: each draw weighs the blocks anew and takes one Gauss-Newton step from the parameters found.
struct Bootstrap {
  std::vector<Interval> interval;                // by unknown
  std::vector<std::vector<double>> params;       // by draw, for whatever follows from them
  std::vector<Eigen::VectorXd> posterior_moves;  // drawn by prior and curvature (Laplace's approximation)
};
Bootstrap bootstrap(const BlockedNormalEquations& blocks, std::span<const double> params,
                    std::span<const Unknown> unknowns, unsigned seed = 1);

}  // namespace gripline::calibrate
