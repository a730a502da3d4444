// The covariance of one Gaussian process over six inputs, and its fit by marginal likelihood.
//
//   k(a, b) = signal exp(-1/2 sum_i ((a_i - b_i) / length_i)^2) + constant,   observations with variance `noise`
//
// Inputs and targets are standardised by the caller, so lengths and variances are pure numbers.
// Source: Rasmussen, Williams, Gaussian Processes for Machine Learning, eqs. (2.30), (5.8), (5.9).
#pragma once

#include <Eigen/Core>
#include <array>

namespace gripline::gp {

inline constexpr int inputs = 6;
using InputRow = Eigen::Matrix<double, 1, inputs>;

struct Kernel {
  std::array<double, inputs> length = {1, 1, 1, 1, 1, 1};
  double signal = 1, constant = 0.1, noise = 1e-3;
};

inline constexpr int hyper_count = inputs + 3;
using HyperVector = Eigen::Matrix<double, hyper_count, 1>;
/// Logarithm of the marginal likelihood of targets y at the rows of x, and its gradient (null: not asked for) by the
/// logarithms of (length..., signal, constant, noise). Costs rows^3. Minus infinity, and no gradient, where the
/// covariance is not positive definite.
double log_likelihood(const Kernel& kernel, const Eigen::MatrixXd& x, const Eigen::VectorXd& y, HyperVector* gradient);

/// Climbs the marginal likelihood from `start` by L-BFGS within fixed bounds (lengths 0.1 to 100, signal 1e-2 to 1e3,
/// constant 1e-3 to 1e2, noise 1e-3 to 1: with less, a process that interpolates its samples predicts the next lap
/// worse). Deterministic; at most `iterations` steps.
Kernel fit_kernel(const Kernel& start, const Eigen::MatrixXd& x, const Eigen::VectorXd& y, int iterations);

}  // namespace gripline::gp
