// What the dynamics' bending adds to the Hessian of the Lagrangian, learned from the Jacobians of successive iterates.
//
// The Gauss-Newton Hessian leaves out C_k = sum_i pi_k+1,i d2 f_i / dz2, z = (x, u). Where the reference cannot be followed
// the multipliers pi are large and Gauss-Newton creeps. Every iteration shows how J_k = df/dz changed along the step s_k:
// C_k s_k = (J_k+ - J_k)' pi_k+1. The symmetric rank-one update keeps C_k consistent with that, stage by stage
// (partitioned secant method: Griewank, Toint 1982; symmetric rank one: Conn, Gould, Toint 1991). It costs no evaluation of
// the model, and what was learned moves along with the horizon.
#pragma once

#include <span>
#include <vector>

#include "controllers/mpc_sqp/riccati.hpp"

namespace gripline::mpc {

/// Rows of an iterate, x [N+1][states], u [N][2], and of its linearisation, a [N][states][states], b [N][states][2].
struct LinearisedRows {
  std::span<const double> x, u, a, b;
};

class Curvature {
 public:
  Curvature(int horizon, int states);

  /// Learns from the step between two iterates. `multipliers`: pi_k at [k][stride], k = 1 .. N.
  void learn(const LinearisedRows& from, const LinearisedRows& to, const double* multipliers, int stride);
  /// Adds C_k to the Hessian of the links.
  void add_to(ocp::Links& links) const;
  /// One stage ahead in time.
  void shift();
  void forget();
  bool empty() const { return empty_; }

 private:
  void stage_step(const LinearisedRows& from, const LinearisedRows& to, int k);
  void stage_change(const LinearisedRows& from, const LinearisedRows& to, const double* pi, int k);
  void update(double* c);

  int horizon_, states_, size_;
  bool empty_ = true;
  std::vector<double> c_;                         // [N][size][size], size = states + 2, z = (x, u)
  std::vector<double> step_, change_, residual_;  // s_k, (J_k+ - J_k)' pi_k+1 and r of the stage at hand
};

}  // namespace gripline::mpc
