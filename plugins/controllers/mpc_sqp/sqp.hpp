// Sequential quadratic programming for the problem of mpc_problem.hpp, in real time.
//
// Multiple shooting: states and inputs of all stages are iterated; one call of the prediction linearises all of them. The
// cost is quadratic but for the soft edges, which the quadratic program keeps exactly, so only the dynamics are
// approximated: by their Jacobians, and by the curvature that the iterates themselves show (curvature.hpp). Each step is
// the solution of an OcpQp in the steps of x and u, with the throttle of the step before as one more state.
//
// Steps are damped from the first iteration on: a step is shortened until the merit, cost + sum_i price_i |defect_i|, falls
// by a share of what the program promised (Han 1977), and after a shortened step the next ones pay for their length
// (Levenberg 1944). The end is decided by iterations and step size, never by time: same input, same output.
#pragma once

#include <span>
#include <vector>

#include "common/mpc/mpc_problem.hpp"
#include "controllers/mpc_sqp/curvature.hpp"
#include "controllers/mpc_sqp/ocp_qp.hpp"

namespace gripline::mpc {

struct SqpOptions {
  int iterations = 20;      // quadratic programs per solve
  double tolerance = 5e-3;  // of the largest step of an input, as a share of its range
  ocp::QpOptions qp;
};

enum class SqpStatus {
  converged,
  iteration_limit,
  no_descent,  // no step improves the merit
  no_step,     // a quadratic program could not be solved
  not_finite   // the prediction at the start is not finite
};

struct SqpReport {
  SqpStatus status = SqpStatus::not_finite;
  int iterations = 0;                                      // quadratic programs
  int predictions = 0;                                     // calls of the prediction
  int active_set_iterations = 0, interior_iterations = 0;  // within the quadratic programs
  double cost = 0;
};

class Sqp {
 public:
  Sqp(int horizon, int states, const SqpOptions& options);

  int states() const { return states_; }

  /// Rows of the iterate: x [N+1][states], u [N][2]. After a solve, the plan; after one that did not converge, the last
  /// iterate accepted.
  std::span<double> x() { return now_.x; }
  std::span<double> u() { return now_.u; }

  /// A first iterate: the references pursued from the present state. Forgets what was learned.
  void guess(const Problem& problem, Prediction& model);
  /// Moves the iterate, and what is known of active bounds and curvature, one step ahead in time.
  void shift();
  /// Iterates from x() and u(), x_0 replaced by the problem's. Allocates nothing (the prediction may, once).
  SqpReport solve(const Problem& problem, Prediction& model);

 private:
  struct Iterate {
    std::vector<double> x, u, x_next, a, b;  // rows as above; x_next [N][states]
    double cost = 0;
    operator LinearisedRows() const { return {x, u, a, b}; }
  };

  void meet(const Problem& problem);
  Input pursue(const Problem& problem, const double* x, int k) const;
  bool linearise(const Problem& problem, Prediction& model, Iterate& at);
  bool solve_step_program(const Problem& problem, SqpReport& report);
  void set_step_program(const Problem& problem);
  void set_hessian(const Problem& problem);
  double step_size(const Problem& problem) const;
  double squared_step(const Problem& problem) const;
  void take_step(double length, Iterate& to) const;
  double search(const Problem& problem, Prediction& model, SqpReport& report);
  void price_defects();
  double defect_cost(const Iterate& at) const;

  int horizon_, states_;
  SqpOptions options_;
  ocp::OcpQp program_;
  ocp::OcpQpSolver solver_;
  Curvature curvature_;
  ocp::Buffer multipliers_;     // of the dynamics, [N+1][links.n]
  std::vector<double> prices_;  // of a unit of defect per state
  double damping_ = 0;          // cost of a squared step of the inputs in units of their ranges
  double promised_ = 0;         // fall of the merit by a full step
  Iterate now_, trial_;
};

}  // namespace gripline::mpc
