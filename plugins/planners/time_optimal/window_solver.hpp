// The program of lap_solver.hpp over a part of the lap, by an interior-point method whose work per iteration is linear
// in the part's nodes and which allocates nothing.
//
//   minimise  sum_k ds_k time(z_k) (1 + w (rate_k / rate_max)^2) - mu sum_i ln t_i      z_k = ((x_k + x_k+1) / 2, u_k)
//           + |x_0 - begin|^2_W / 2 + |x_M - end|^2_W / 2
//   subject to  x_k+1 - x_k = ds_k dx/ds(z_k),   c_i(z_k) + t_i = 0,  t_i > 0
//
// The constraints c are those of lap_solver.hpp, offsets n at nodes and half-way between them. One iteration is one
// Newton step on the optimality conditions at the barrier mu: exact Jacobians and Hessian of the Lagrangian
// (interval_program.hpp), the implicit midpoint solved for x_k+1 and a Riccati recursion over the nodes
// (window_riccati.hpp), a step shortened until a merit function falls or a filter of trial points takes it
// (window_search.hpp).
// Each slack and each multiplier is kept positive by itself, so that no single one of them makes the whole step short.
// A slack is never less than what its constraint leaves at the iterate, since bounds may move. Where side forces and
// drive share friction constraints are curved, in every interval: there a slack is what its constraint leaves after the
// step too, if that is not much less than the step says, and the merit function has a penalty of its own for every
// state's dynamics and every kind of constraint, as large as their own multipliers ask for. The barrier rises over the
// last quarter of a window, to `end_barrier`: what is planned there depends on how the window is made to end, and
// changes less from one window to the next where the plan keeps away from constraints. mu stays where it is once it is
// small, so that an iterate of a moment ago is a warm start for a part that was moved on, or for other tyres. Sources:
// Waechter, Biegler (2006), "On the implementation of an interior-point filter line-search algorithm for large-scale
// nonlinear programming" (the terms, correction of the inertia); Rao, Wright, Rawlings (1998), "Application of
// interior-point methods to model predictive control" (the recursion).
#pragma once

#include <cstddef>
#include <vector>

#include "planners/time_optimal/interval_program.hpp"
#include "planners/time_optimal/window_newton.hpp"
#include "planners/time_optimal/window_riccati.hpp"
#include "planners/time_optimal/window_search.hpp"

namespace gripline::time_optimal {

struct WindowStep {
  double change = 0;  // largest of the Newton step, in units of the variables' typical sizes
  double defect = 0;  // largest violation of the dynamics and of the constraints, in those units
  // Change and defect in the first three quarters of the window: the rest depends on how it is made to end.
  double near_change = 0, near_defect = 0;
  double share = 0;   // of the step that was taken
  bool good = false;  // false: no step was found, states and multipliers are as they were
};

class WindowSolver {
 public:
  /// For windows of up to `nodes` intervals of this problem, which is copied.
  WindowSolver(const LapProblem& problem, std::size_t nodes);

  /// What is believed of the car from now on. `more` is resistance beyond that of the problem's coasting curve.
  void set_car(const AxleTyres& tyres, const SpecificResistance& more);
  /// Friction of the interval that begins at a node, over that of set_car().
  void set_grip(std::size_t node, double grip);
  /// Plans slips of a slow car (TyreUse) up to this angle from the next set_car() on [rad].
  void set_slip_bound_slow_car(double slip) { program_.set_slip_bound_slow_car(slip); }
  double slip_bound_slow_car() const { return program_.slip_bound_slow_car(); }
  /// The largest slip angle that is planned [rad]: the problem's, and where side forces and drive share friction none
  /// beyond a tyre's peak, where it is a brake.
  double largest_slip() const { return program_.largest_slip(); }
  /// Intervals of a window of `count` that do not depend on how it is made to end.
  static std::size_t near_part(std::size_t count) { return count - count / 4; }
  /// Weights of begin and end, in seconds per squared typical size.
  static constexpr double begin_weight = WindowModel::begin_weight, end_weight = WindowModel::end_weight;
  static constexpr double end_barrier = 2e-4;  // [s]

  /// One Newton step of the nodes first .. first + count (indices wrap) of `lap`, which has a node for each of the
  /// problem's. `begin` and `end` are the states near which the window begins and ends.
  WindowStep iterate(std::vector<WindowNode>& lap, std::size_t first, std::size_t count, double mu,
                     const LapVariables& begin, const LapVariables& end);

  const LapProblem& problem() const { return program_.problem(); }

 private:
  void set_barriers(double mu);
  void evaluate(std::vector<WindowNode>& lap, std::size_t k);
  void set_model(const IntervalDerivatives& d, IntervalModel& model) const;
  static void start_constraints(WindowNode& node, const IntervalModel& model);
  static void add_constraints(const WindowNode& node, IntervalModel& model);
  /// mu / t + lambda / t (c + t): the force of every constraint's barrier, and lambda / t, its stiffness.
  struct Barriers {
    RowValues force, stiff;
  };
  static Barriers barriers(const WindowNode& node, const IntervalModel& model);
  void eliminate(const WindowNode& here, const WindowNode& there, std::size_t i, std::size_t k);
  void measure_defect(const std::vector<WindowNode>& lap, WindowStep& result) const;
  void steps_of_constraints(const std::vector<WindowNode>& lap);
  void measure_change(WindowStep& result) const;
  void advance(std::vector<WindowNode>& lap, double share);

  IntervalProgram program_;
  IntervalDerivatives derivatives_;  // of the interval that is evaluated
  double mu_ = 0;                    // barrier
  WindowModel window_;
  WindowRiccati riccati_;
  WindowSearch search_;
};

}  // namespace gripline::time_optimal
