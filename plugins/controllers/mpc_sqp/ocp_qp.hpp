// A quadratic program with the structure of an optimal control problem, and its solver.
//
//   minimise   sum_k  1/2 z_k' H_k z_k + g_k' z_k  +  sum_k  penalty(a_k' x_k),       z_k = (u_k, x_k)
//   subject to x_0 given,   x_k+1 = A_k x_k + B_k u_k + c_k        k = 0 .. N-1
//              lower_k <= (u_k0, u_k1, x_k[bounded]) <= upper_k    (inputs k = 0 .. N-1, the state k = 1 .. N)
//              lower_k <= a_k' x_k <= upper_k, softly              (k = 1 .. N)
//
// The soft row has a slack eps >= 0 on either side with the penalty quadratic eps^2 + linear eps; the slacks never become
// variables. Two inputs, any number of states. What couples an input to its predecessor is expressed by a state that
// remembers it.
//
// Method: an active set is guessed (from the last solution, or none active) and corrected by Newton steps on the
// piecewise linear optimality conditions, each one Riccati sweep (a primal-dual active set method: Hintermueller, Ito,
// Kunisch 2002). If that does not settle, a primal-dual interior-point method with Mehrotra's predictor and corrector
// (Wright, Primal-Dual Interior-Point Methods, 1997; stage-wise as in Rao, Wright, Rawlings 1998) takes over and hands its
// active set back for an exact finish. Both share one Riccati recursion.
#pragma once

#include <cstdint>
#include <memory>

#include "controllers/mpc_sqp/riccati.hpp"
#include "controllers/mpc_sqp/vec4.hpp"

namespace gripline::ocp {

/// Which part of a row's piecewise penalty holds: free between the bounds, held at a bound, or past a soft one.
enum class Side : std::int8_t { past_lower = -2, at_lower = -1, free = 0, at_upper = 1, past_upper = 2 };

/// Data of the program. Rows that a stage lacks (state rows at k = 0, input rows at k = N) are ignored whatever they hold.
/// Infinite bounds are allowed; a lower bound above its upper one is not. All memory is taken by the constructor.
class OcpQp {
 public:
  OcpQp(int horizon, int states);

  int horizon() const { return links.horizon; }
  int states() const { return links.states; }

  /// [row_count] bounds of stage k.
  double* lower(int k) { return bounds_.data() + 2 * row_count * k; }
  double* upper(int k) { return lower(k) + row_count; }
  const double* lower(int k) const { return bounds_.data() + 2 * row_count * k; }
  const double* upper(int k) const { return lower(k) + row_count; }

  Links links;
  double soft_quadratic = 1.0;  // > 0
  double soft_linear = 0.0;     // >= 0

 private:
  Buffer bounds_;
};

struct QpOptions {
  int active_set_iterations = 8;  // Riccati sweeps to settle an active set before the interior-point method is asked
  int interior_iterations = 40;
  double tolerance = 1e-8;           // of rows and multipliers, relative to a row's width and to the curvature along it
  double interior_tolerance = 1e-7;  // the same for an interior solution, taken if no active set is settled
};

struct QpReport {
  bool solved = false;
  bool exact = false;  // the active set is settled: solved to rounding
  int active_set_iterations = 0, interior_iterations = 0;
};

/// Solver and solution. Work space is taken by the constructor; solve() allocates nothing.
class OcpQpSolver {
 public:
  OcpQpSolver(int horizon, int states);
  ~OcpQpSolver();
  OcpQpSolver(OcpQpSolver&&) noexcept;
  OcpQpSolver& operator=(OcpQpSolver&&) noexcept;

  /// Solves `qp` with x_0 = `x0` ([states], null for zero), starting from the sides left by the last solve or set by
  /// side(). On failure (infeasible, unbounded, not finite, out of iterations) the solution is unspecified.
  QpReport solve(const OcpQp& qp, const double* x0, const QpOptions& options);

  /// Solution: [2] and [states].
  const double* input(int k) const;
  const double* state(int k) const;
  /// [row_count] multipliers of stage k: positive at the upper bound, negative at the lower. A guess before a solve.
  double* row_multiplier(int k);
  const double* row_multiplier(int k) const;
  /// [row_count] sides of stage k. A guess before a solve.
  Side* side(int k);
  const Side* side(int k) const;
  /// Multipliers of x_k = A x_k-1 + B u_k-1 + c_k-1 at the solution of `qp`: pi_k [links.n] for k = 1 .. N at pi + k n, the
  /// derivative of the optimal cost by c_k-1. One pass over the horizon.
  void dynamics_multipliers(const OcpQp& qp, double* pi) const;
  /// No guess: every row free.
  void forget_guess();

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace gripline::ocp
