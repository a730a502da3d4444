// The nonlinear program of mpc/ocp.hpp as the SQP method sees it: an iterate, its linearisation, and the quadratic
// program in the steps of x and u. The parts are named as in acados' ocp_nlp.
//
// Multiple shooting: states and inputs of all stages are iterated; one call of the prediction linearises all of them.
// The cost is quadratic but for the soft edges, which the quadratic program keeps exactly, so only the dynamics are
// approximated. The program's state is the car's with the throttle of the step before as one more, so that dims.nx =
// states + 1.
#pragma once

#include <vector>

#include "common/mpc/ocp.hpp"
#include "controllers/mpc_sqp/ocp_qp.hpp"

namespace gripline::mpc_sqp {

/// An iterate and its linearisation.
struct NlpIterate {
  NlpIterate(int N, int nx);

  std::vector<double> x, u;    // [N+1][nx], [N][2]
  std::vector<double> x_next;  // predictions from x_k, u_k [N][nx]
  std::vector<double> A, B;    // their Jacobians [N][nx][nx], [N][nx][2]
  double cost = 0;
};

/// Index of the heading and of the steering angle in a state.
inline constexpr int yaw_index = 2, delta_index = 6;

/// Ranges of the inputs, the units of their steps.
inline double d_range(const Car& car) { return car.d_max - car.d_min; }
inline double ddelta_range(const Car& car) { return 2 * car.ddelta_max; }

/// Predictions and cost of an iterate; false if anything of it is not finite.
bool predict(const mpc::Ocp& ocp, Prediction& model, NlpIterate& at);
/// Predictions with their Jacobians, and cost, of an iterate; false if anything of it is not finite.
bool linearise(const mpc::Ocp& ocp, Prediction& model, NlpIterate& at);

/// Q, R, S of the tracking cost with `damping`, a cost of squared steps of the inputs in units of their ranges, and the
/// slack weights. Gauss-Newton: exact for this cost.
void set_cost_hessian(const mpc::Ocp& ocp, double damping, OcpQp& qp);
/// q and r of the cost at an iterate.
void set_cost_gradient(const mpc::Ocp& ocp, const NlpIterate& at, OcpQp& qp);
/// Bounds of the steps from an iterate, and C.
void set_constraints(const mpc::Ocp& ocp, const NlpIterate& at, OcpQp& qp);
/// A, B, b of the linearised dynamics. Returns the largest defect |x_next - x| of the iterate.
double set_dynamics(const NlpIterate& at, int nx, OcpQp& qp);

}  // namespace gripline::mpc_sqp
