// Sequential quadratic programming for the problem of mpc/ocp.hpp, in real time.
//
// Each step is the solution of an OcpQp (ocp_nlp.hpp), whose Hessian is Gauss-Newton's with the curvature that the
// iterates themselves show (sr1_hessian.hpp). Steps are globalised from the first iteration on (globalization.hpp): a
// step is shortened until the merit falls by a share of the predicted decrease. Iterations and step size decide the
// end, never time: same input, same output.
#pragma once

#include <span>
#include <vector>

#include "common/mpc/ocp.hpp"
#include "controllers/mpc_sqp/globalization.hpp"
#include "controllers/mpc_sqp/ocp_nlp.hpp"
#include "controllers/mpc_sqp/ocp_qp_solver.hpp"
#include "controllers/mpc_sqp/sr1_hessian.hpp"

namespace gripline::mpc_sqp {

struct SqpOptions {
  int max_iter = 20;       // quadratic programs per solve
  double tol_step = 5e-3;  // of the largest step of an input, as a share of its range
  OcpQpSolverOptions qp_solver;
};

enum class SqpStatus {
  converged,
  max_iter,
  min_step,     // no step improves the merit
  qp_failure,   // a quadratic program could not be solved
  nan_detected  // the prediction at the start is not finite
};

struct SqpStatistics {
  SqpStatus status = SqpStatus::nan_detected;
  int sqp_iter = 0;                            // quadratic programs
  int predictions = 0;                         // calls of the prediction
  int qp_active_set_iter = 0, qp_ip_iter = 0;  // within the quadratic programs
  double cost = 0;
  double res_eq = 0;     // largest defect of the last iterate that was linearised, in the states' own units
  double step_norm = 0;  // largest step of an input in the last program's solution, as a share of its range
};

class Sqp {
 public:
  /// `nx`: states of the prediction. All memory is taken here.
  Sqp(int N, int nx, const SqpOptions& options);

  int states() const { return nx_; }

  /// Rows of the iterate: x [N+1][nx], u [N][2]. After a solve, the plan; after one that did not converge, the last
  /// iterate accepted.
  std::span<double> x() { return now_.x; }
  std::span<double> u() { return now_.u; }

  /// A first iterate: the references pursued from the present state. Forgets active set and curvature.
  void initialize(const mpc::Ocp& ocp, Prediction& model);
  /// Moves the iterate, and what is known of active bounds and curvature, one step ahead in time.
  void shift();
  /// Iterates from x() and u(), x_0 replaced by the problem's. Allocates nothing (the prediction may, once).
  SqpStatistics solve(const mpc::Ocp& ocp, Prediction& model);

 private:
  Input pursuit_input(const mpc::Ocp& ocp, const double* x, int k) const;
  void set_x0(const mpc::Ocp& ocp);
  void clip_steering(const mpc::Ocp& ocp);
  bool solve_qp(const mpc::Ocp& ocp, SqpStatistics& statistics);
  double step_norm(const mpc::Ocp& ocp, int stages) const;
  bool converged(const mpc::Ocp& ocp, const SqpStatistics& statistics) const;
  double squared_step(const mpc::Ocp& ocp) const;
  void take_step(double alpha, NlpIterate& to) const;
  double line_search(const mpc::Ocp& ocp, Prediction& model, SqpStatistics& statistics);

  int N_, nx_;
  SqpOptions options_;
  OcpQp qp_;
  OcpQpSolver qp_solver_;
  Sr1Hessian sr1_;
  Buffer pi_;  // multipliers of the dynamics [N+1][ldx]
  MeritFunction merit_;
  LevenbergMarquardt levenberg_marquardt_;
  double predicted_decrease_ = 0;  // of the merit by a full step
  double last_step_ = 0;           // step_norm that was taken
  double trusted_step_ = 0;        // largest step_norm that learned curvature may ask for
  NlpIterate now_, trial_;
  std::vector<double> steering_low_, steering_high_;  // within which later bounds can be reached, k = 1 .. N [rad]
};

}  // namespace gripline::mpc_sqp
