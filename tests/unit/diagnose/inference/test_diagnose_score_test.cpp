#include <gtest/gtest.h>

#include <random>

#include "diagnose/inference/score_test.hpp"

namespace gripline::diagnose {
namespace test_diagnose_score_test {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Linear regression with unit noise: y = X theta + e. There the score test is exact.
struct Regression {
  MatrixXd X;
  VectorXd y;
  Regression(Index rows, const VectorXd& theta, unsigned seed) : X(rows, theta.size()), y(rows) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    for (Index i = 0; i < rows; ++i) {
      for (Index j = 0; j < theta.size(); ++j) X(i, j) = normal(random);
      y[i] = X.row(i).dot(theta) + normal(random);
    }
  }
  double cost(Index columns) const {
    const VectorXd theta = X.leftCols(columns).colPivHouseholderQr().solve(y);
    return 0.5 * (y - X.leftCols(columns) * theta).squaredNorm();
  }
};

TEST(ScoreTest, GainAndStepAreThoseOfTheLargerRegression) {
  VectorXd theta(5);
  theta << 1.0, -2.0, 0.3, 0.0, 0.1;
  const Regression r(200, theta, 3);
  const ScoreTest s = score_test(r.X.transpose() * r.X, r.X.transpose() * r.y, 2);
  EXPECT_EQ(s.dof, 3U);
  EXPECT_NEAR(s.gain, r.cost(2) - r.cost(5), 1e-8);
  const VectorXd all = r.X.colPivHouseholderQr().solve(r.y);
  for (Index i = 0; i < 3; ++i) EXPECT_NEAR(s.step[i], all[2 + i], 1e-9) << i;
}

TEST(ScoreTest, ScaleOfARegressorDoesNotMatter) {
  VectorXd theta(3);
  theta << 1.0, 0.2, -0.1;
  Regression r(100, theta, 5);
  const double gain = score_test(r.X.transpose() * r.X, r.X.transpose() * r.y, 1).gain;
  r.X.col(2) *= 1e6;
  EXPECT_NEAR(score_test(r.X.transpose() * r.X, r.X.transpose() * r.y, 1).gain, gain, 1e-6 * gain);
}

/// What the own parameters or another regressor explain as well counts for nothing.
TEST(ScoreTest, CollinearRegressorsAreLeftOut) {
  VectorXd theta(4);
  theta << 1.0, 0.4, 0.0, 0.0;
  Regression r(100, theta, 7);
  const double gain =
      score_test(r.X.leftCols(2).transpose() * r.X.leftCols(2), r.X.leftCols(2).transpose() * r.y, 1).gain;
  r.X.col(2) = -3.0 * r.X.col(1);
  r.X.col(3) = 2.0 * r.X.col(0);
  const ScoreTest s = score_test(r.X.transpose() * r.X, r.X.transpose() * r.y, 1);
  EXPECT_EQ(s.dof, 1U);
  EXPECT_NEAR(s.gain, gain, 1e-6 * gain);
}

/// Regressors of pure noise: twice the gain is a chi-square.
TEST(ScoreTest, TwiceTheGainIsAChiSquareWhenNothingIsMissing) {
  VectorXd theta = VectorXd::Zero(6);
  theta[0] = 1.0;
  double sum = 0.0, squares = 0.0;
  constexpr int draws = 400;
  for (int draw = 0; draw < draws; ++draw) {
    const Regression r(60, theta, 100 + static_cast<unsigned>(draw));
    const double twice = 2.0 * score_test(r.X.transpose() * r.X, r.X.transpose() * r.y, 2).gain;
    sum += twice / draws;
    squares += twice * twice / draws;
  }
  EXPECT_NEAR(sum, 4.0, 0.5);                  // mean: 4 degrees of freedom
  EXPECT_NEAR(squares - sum * sum, 8.0, 2.5);  // variance: twice that
}

}  // namespace test_diagnose_score_test
}  // namespace gripline::diagnose
