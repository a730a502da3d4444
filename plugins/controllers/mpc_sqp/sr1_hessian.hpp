// What the curvature of the dynamics adds to the Hessian of the Lagrangian, learned from the Jacobians of successive
// iterates.
//
// The Gauss-Newton Hessian leaves out C_k = sum_i pi_k+1,i d2 f_i / dw2, w = (x, u). Where the reference cannot be
// followed the multipliers pi are large and Gauss-Newton converges slowly. Every iteration shows how J_k = df/dw
// changed along the step s_k: C_k s_k = (J_k+ - J_k)' pi_k+1. The symmetric rank-one (SR1) update keeps C_k consistent
// with that, stage by stage (partitioned secant method: Griewank, Toint 1982; symmetric rank one: Conn, Gould, Toint
// 1991). It costs no evaluation of the model, and what was learned moves along with the horizon.
#pragma once

#include <vector>

#include "controllers/mpc_sqp/ocp_nlp.hpp"
#include "controllers/mpc_sqp/ocp_qp.hpp"

namespace gripline::mpc_sqp {

class Sr1Hessian {
 public:
  Sr1Hessian(int N, int nx);

  /// Learns from the step between two linearised iterates. `pi`: pi_k at pi + k ldpi, k = 1 .. N.
  void update(const NlpIterate& from, const NlpIterate& to, const double* pi, int ldpi);
  /// Adds `share` C_k to Q, S and R of the program.
  void add_to(OcpQp& qp, double share = 1) const;
  /// One stage ahead in time.
  void shift();
  /// Back to zero.
  void reset();
  bool empty() const { return empty_; }

 private:
  void set_step(const NlpIterate& from, const NlpIterate& to, int k);
  void set_change(const NlpIterate& from, const NlpIterate& to, const double* pi, int k);
  void update_stage(double* c);

  int N_, nx_, size_;
  bool empty_ = true;
  std::vector<double> c_;                         // [N][size][size], size = nx + 2, w = (x, u)
  std::vector<double> step_, change_, residual_;  // s_k, (J_k+ - J_k)' pi_k+1 and r of the stage at hand [size]
};

}  // namespace gripline::mpc_sqp
