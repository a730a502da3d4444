// Quadratic programs over a closed line: each unknown couples to two neighbours on both sides, each has bounds.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gripline {

/// Symmetric n x n matrix, n >= 8: A[i][i] = diagonal[i], A[i][i+1]
/// = next[i], A[i][i+2] = second[i], with indices modulo n.
struct CyclicPentadiagonal {
  explicit CyclicPentadiagonal(std::size_t n) : diagonal(n), next(n), second(n) {}
  std::size_t size() const { return diagonal.size(); }
  std::vector<double> multiply(std::span<const double> x) const;
  std::vector<double> diagonal, next, second;
};

/// LDL^T of a positive definite cyclic pentadiagonal matrix, the last two unknowns kept as a border. Linear in n.
class CyclicPentadiagonalFactor {
 public:
  explicit CyclicPentadiagonalFactor(const CyclicPentadiagonal& matrix);
  /// Solves A x = x in place.
  void solve(std::span<double> x) const;

 private:
  void solve_band(std::span<double> x) const;
  void solve_band(std::span<double> x, std::span<double> y) const;
  std::vector<double> pivot_, first_, second_;  ///< of the leading n-2 unknowns
  std::vector<double> border_u_, border_v_;     ///< band^-1 times the two border columns
  std::vector<double> column_u_, column_v_;     ///< the border columns themselves
  double schur_uu_ = 0.0, schur_uv_ = 0.0, schur_vv_ = 0.0;
};

/// Minimises x' H x / 2 + gradient' x over lower <= x <= upper (lower < upper) by Mehrotra's primal-dual interior point
/// method. Returns x strictly inside the bounds; stops at complementarity `tolerance` relative to the problem's own
/// scale.
std::vector<double> solve_cyclic_box_qp(const CyclicPentadiagonal& hessian, std::span<const double> gradient,
                                        std::span<const double> lower, std::span<const double> upper,
                                        double tolerance = 1e-10);

}  // namespace gripline
