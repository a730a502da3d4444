// The linear-quadratic problem of one Newton step, solved by dynamic programming over the horizon.
//
//   minimise    cost of the OcpQp without slacks  +  sum_k 1/2 v_k' diag(Gamma_k) v_k + gamma_k' v_k
//   subject to  x_0 given,  x_k+1 = A_k x_k + B_k u_k + b_k,      v_k = (u_k0, u_k1, x_k[idxbx], C_k x_k)
//
// Gamma and gamma are what an active set or a barrier adds along the constraints; they change between Newton steps
// while the program stays. factorize() is the part that depends on Gamma, solve() the part that depends on gamma: a
// predictor and a corrector share a factorisation.
// Source: Rao, Wright, Rawlings (1998), "Application of interior-point methods to model predictive control"; the names
// of the terms are HPIPM's.
#pragma once

#include <cstddef>
#include <memory>

#include "controllers/mpc_sqp/ocp_qp.hpp"

namespace gripline::mpc_sqp {

/// What is added along the constraints, [N+1][con_count] each.
struct ConstraintTerms {
  explicit ConstraintTerms(int N) : Gamma(con_count * static_cast<std::size_t>(N + 1)), gamma(Gamma.size()) {}
  Buffer Gamma, gamma;  // to the Hessian, to the gradient
};

class Riccati {
 public:
  virtual ~Riccati() = default;
  /// Cost to go of every stage; false if the problem is not strictly convex in the inputs or not finite.
  virtual bool factorize(const OcpQp& qp, const ConstraintTerms& terms) = 0;
  /// ux [N+1][ldux] and v [N+1][con_count] of the minimum, from x_0 in ux. After factorize().
  virtual void solve(const OcpQp& qp, const ConstraintTerms& terms, double* ux, double* v) = 0;
  /// Second derivative of the optimal cost along each constraint [N+1][con_count], its own Gamma included. After
  /// factorize().
  virtual void curvatures(const OcpQp& qp, double* curvature) const = 0;
};

/// The recursion compiled for up to 4, 8, 12 or 16 states, or with loops of any length.
std::unique_ptr<Riccati> make_riccati(int N, int nx);

}  // namespace gripline::mpc_sqp
