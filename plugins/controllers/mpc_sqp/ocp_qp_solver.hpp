// Solver of the OcpQp.
//
// An active set is guessed (from the last solution, or none active) and corrected by Newton steps on the piecewise
// linear optimality conditions (active_set.hpp). If that does not settle, an interior-point method takes over and hands
// its active set back for an exact finish (interior_point.hpp). Both share one Riccati recursion.
#pragma once

#include <memory>

#include "controllers/mpc_sqp/active_set.hpp"
#include "controllers/mpc_sqp/ocp_qp.hpp"

namespace gripline::mpc_sqp {

struct OcpQpSolverOptions {
  int active_set_iter_max = 8;  // factorisations to settle an active set before the interior-point method is asked
  int ip_iter_max = 40;         // interior-point steps; 0: the method is not asked
  double tol = 1e-8;            // of bounds and multipliers, relative to a bound's range and to the curvature along it
  double ip_tol = 1e-7;         // as `tol`, of an interior-point solution: taken if no active set is settled
};

struct OcpQpSolverStatistics {
  bool solved = false;
  bool exact = false;  // the active set is settled: solved to rounding
  int active_set_iter = 0, ip_iter = 0;
};

/// Solver and solution. Work space is taken by the constructor; solve() allocates nothing.
class OcpQpSolver {
 public:
  OcpQpSolver(int N, int nx);
  ~OcpQpSolver();
  OcpQpSolver(OcpQpSolver&&) noexcept;
  OcpQpSolver& operator=(OcpQpSolver&&) noexcept;

  /// Solves `qp` with x_0 = `x0` ([nx], null for zero), starting from the active set left by the last solve or set by
  /// status(). On failure (infeasible, unbounded, not finite, out of iterations) the solution is unspecified.
  OcpQpSolverStatistics solve(const OcpQp& qp, const double* x0, const OcpQpSolverOptions& options);

  /// Solution: [nu] and [nx].
  const double* u(int k) const;
  const double* x(int k) const;
  /// [con_count] multipliers of stage k: positive at the upper bound, negative at the lower. A guess before a solve.
  double* lam(int k);
  const double* lam(int k) const;
  /// [con_count] bounds' status of stage k. A guess before a solve.
  BoundStatus* status(int k);
  const BoundStatus* status(int k) const;
  /// Multipliers of x_k = A x_k-1 + B u_k-1 + b_k-1 at the solution of `qp`: pi_k [ldx] for k = 1 .. N at pi + k ldx,
  /// the derivative of the optimal cost by b_k-1. One pass over the horizon; `pi` is the caller's, [N+1][ldx].
  void get_pi(const OcpQp& qp, double* pi) const;
  /// No guess: every bound inactive.
  void reset();

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace gripline::mpc_sqp
