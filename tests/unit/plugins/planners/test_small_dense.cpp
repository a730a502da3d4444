#include "planners/time_optimal/small_dense.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

namespace gripline {
namespace test_small_dense {

using namespace time_optimal;

template <class Matrix>
Matrix random_matrix(std::mt19937& random) {
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  return Matrix::NullaryExpr([&] { return number(random); });
}

// Also where a pivot is zero, so that rows must be exchanged.
TEST(SmallDense, EliminatesAllRightHandSides) {
  std::mt19937 random(1);
  for (int i = 0; i < 20; ++i) {
    auto rows = random_matrix<SixEquations>(random);
    if (i % 2 == 0) rows(0, 0) = rows(1, 1) = 0.0;
    const Eigen::Matrix<double, 6, 6> matrix = rows.leftCols<6>();
    const Eigen::Matrix<double, 6, 9> right = rows.middleCols<9>(6);
    eliminate_rows(rows);
    const Eigen::Matrix<double, 6, 9> solution = rows.middleCols<9>(6);
    EXPECT_LT((matrix * solution - right).norm(), 1e-10 * matrix.inverse().norm()) << i;
  }
}

TEST(SmallDense, ASingularMatrixGivesNothingFinite) {
  std::mt19937 random(2);
  auto rows = random_matrix<SixEquations>(random);
  rows.col(2).setZero();
  eliminate_rows(rows);
  EXPECT_FALSE((rows.middleCols<9>(6).allFinite()));
}

TEST(SmallDense, MultipliesTheFirstSixRows) {
  std::mt19937 random(3);
  const auto A = random_matrix<Eigen::Matrix<double, 8, 6>>(random);
  auto B = random_matrix<Eigen::Matrix<double, 8, 3>>(random);
  const Eigen::Matrix<double, 8, 3> wanted = A * B.topRows<6>();
  EXPECT_LT((product(A, B) - wanted).norm(), 1e-14);
  B.bottomRows<2>().setConstant(1e9);
  EXPECT_LT((product(A, B) - wanted).norm(), 1e-14);
}

}  // namespace test_small_dense
}  // namespace gripline
