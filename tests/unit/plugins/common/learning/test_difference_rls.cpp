#include "common/learning/difference_rls.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

namespace gripline::learning {
namespace test_difference_rls {

TEST(DifferenceRls, EqualsGeneralisedLeastSquaresWithTheNoisesTrueCovariance) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const int p = 3, steps = 25;
  const double sigma = 0.3, misfit = 0.05, h = 0.1;
  const Eigen::MatrixXd rows = Eigen::MatrixXd::NullaryExpr(steps, p, [&] { return normal(random); });
  const Eigen::VectorXd y = Eigen::VectorXd::NullaryExpr(steps, [&] { return normal(random); });

  DifferenceRls rls(p, 1);
  rls.covariance().setIdentity();
  rls.break_sequence(&sigma);
  for (int k = 0; k < steps; ++k) {
    rls.begin_step(&sigma);
    rls.update(rls.innovation(0, rows.row(k).transpose(), y[k], h, misfit));
  }

  Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(steps, steps);  // of differences of white noise: tridiagonal
  for (int k = 0; k < steps; ++k) {
    noise(k, k) = 2 * sigma * sigma / (h * h) + misfit * misfit;
    if (k > 0) noise(k, k - 1) = noise(k - 1, k) = -sigma * sigma / (h * h);
  }
  const Eigen::MatrixXd weighted = noise.llt().solve(rows);
  const Eigen::MatrixXd covariance = (rows.transpose() * weighted + Eigen::MatrixXd::Identity(p, p)).inverse();
  const Eigen::VectorXd estimate = covariance * (weighted.transpose() * y);
  EXPECT_LT((rls.theta() - estimate).norm(), 1e-10);
  EXPECT_LT((rls.covariance() - covariance).norm(), 1e-10);
}

}  // namespace test_difference_rls
}  // namespace gripline::learning
