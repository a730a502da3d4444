// Algebra of an interval's small dense matrices, in whole vectors of the machine: libraries' blocked kernels are for
// larger ones.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <type_traits>

namespace gripline::time_optimal {

/// Rows of a system of six equations and of its right-hand sides, in whole vectors.
using SixEquations = Eigen::Matrix<double, 6, 16, Eigen::RowMajor>;

/// Solves for all right-hand sides, which stand behind the six columns of the matrix, by elimination with row pivots.
/// Not finite where the matrix is singular.
inline void eliminate_rows(SixEquations& rows) {
  constexpr int n = 6;
  // Columns that are done are not looked at again: `left` are those that count.
  const auto eliminate = [&rows](int k, auto left) {
    int pivot = k;
    for (int i = k + 1; i < n; ++i)
      if (std::abs(rows(i, k)) > std::abs(rows(pivot, k))) pivot = i;
    const auto row = [&](int i) { return rows.row(i).template tail<left>(); };
    if (pivot != k) row(k).swap(row(pivot));
    row(k) *= 1.0 / rows(k, k);
    for (int i = 0; i < n; ++i)
      if (i != k) row(i) -= rows(i, k) * row(k);
  };
  for (int k = 0; k < 4; ++k) eliminate(k, std::integral_constant<int, 16>{});
  for (int k = 4; k < n; ++k) eliminate(k, std::integral_constant<int, 12>{});
}

/// A B for A with six columns and rows in whole vectors; rows of B from the seventh on do not count.
template <int n>
Eigen::Matrix<double, 8, n> product(const Eigen::Matrix<double, 8, 6>& A, const Eigen::Matrix<double, 8, n>& B) {
  Eigen::Matrix<double, 8, n> C;
  for (int j = 0; j < n; ++j) {
    Eigen::Matrix<double, 8, 1> sum = A.col(0) * B(0, j);
    for (int i = 1; i < 6; ++i) sum += A.col(i) * B(i, j);
    C.col(j) = sum;
  }
  return C;
}

}  // namespace gripline::time_optimal
