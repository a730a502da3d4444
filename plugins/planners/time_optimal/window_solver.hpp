// The program of lap_solver.hpp over a part of the lap, by an interior-point method whose work per iteration is linear in
// the part's nodes and which allocates nothing.
//
//   minimise  sum_k ds_k time(z_k) (1 + w (rate_k / rate_max)^2) - mu sum_i ln t_i      z_k = ((x_k + x_k+1) / 2, u_k)
//           + |x_0 - begin|^2_W / 2 + |x_M - end|^2_W / 2
//   subject to  x_k+1 - x_k = ds_k dx/ds(z_k),   c_i(z_k) + t_i = 0,  t_i > 0
//
// The constraints c are those of lap_solver.hpp, offsets n at nodes and half-way between them. One iteration is one
// Newton step on the optimality conditions at the barrier mu: exact Jacobians and Hessian of the Lagrangian, the
// implicit midpoint solved for x_k+1, a Riccati recursion over the nodes, a step shortened until a merit function falls or
// a filter of trial points takes it.
// Each slack and each multiplier is kept positive by itself, so that no single one of them makes the whole step short.
// A slack is never less than what its constraint leaves at the iterate, since bounds may move. Where side forces and drive
// share friction constraints are curved, in every interval: there a slack is what its constraint leaves after the step too,
// if that is not much less than the step says, and the merit function has a penalty of its own for every state's dynamics
// and every kind of constraint, as large as their own multipliers ask for.
// The barrier rises over the last quarter of a window, to `end_barrier`: what is planned there depends on how the window is
// made to end, and changes less from one window to the next where the plan keeps away from constraints.
// mu stays where it is once it is small, so that an iterate of a moment ago is a warm start for a part that was moved on,
// or for other tyres.
// Sources: Waechter, Biegler (2006), "On the implementation of an interior-point filter line-search algorithm for
// large-scale nonlinear programming" (the terms, correction of the inertia); Rao, Wright, Rawlings (1998), "Application
// of interior-point methods to model predictive control" (the recursion).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "planners/time_optimal/interval_program.hpp"
#include "planners/time_optimal/trial_filter.hpp"

namespace gripline::time_optimal {

/// A node of the iterate: the lap's variables there, multipliers of the dynamics to the next node, and slack and
/// multiplier of every constraint.
struct WindowNode {
  std::array<double, lap_variables> z{};
  std::array<double, lap_states> pi{};
  std::array<double, interval_rows> t{}, lambda{};
  bool started = false;  // slacks and multipliers are of an iterate
};

struct WindowStep {
  double change = 0;  // largest of the Newton step, in units of the variables' typical sizes
  double defect = 0;  // largest violation of the dynamics and of the constraints, in those units
  // The same of the first three quarters: what is nearer to its end depends on how it is made to end.
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
  /// Plans slips up to this angle from the next set_car() on [rad].
  void set_slip_most(double slip) { program_.set_slip_most(slip); }
  double slip_most() const { return program_.slip_most(); }
  /// The largest slip angle that is planned [rad]: the problem's, and where side forces and drive share friction none
  /// beyond a tyre's peak, where it is a brake.
  double largest_slip() const { return program_.largest_slip(); }
  /// Intervals of a window of `count` that do not depend on how it is made to end.
  static std::size_t near_part(std::size_t count) { return count - count / 4; }
  /// Weights of begin and end, in seconds per squared typical size.
  static constexpr double begin_weight = 1000.0, end_weight = 100.0;
  static constexpr double end_barrier = 2e-4;  // [s]

  /// One Newton step of the nodes first .. first + count (indices wrap) of `lap`, which has a node for each of the
  /// problem's. `begin` and `end` are the states near which the window begins and ends.
  WindowStep iterate(std::vector<WindowNode>& lap, std::size_t first, std::size_t count, double mu,
                     const std::array<double, lap_variables>& begin, const std::array<double, lap_variables>& end);

  const LapProblem& problem() const { return program_.problem(); }

 private:
  static constexpr int S = lap_states, V = lap_variables, U = V - S, C = interval_rows;
  using StateVector = Eigen::Matrix<double, S, 1>;
  using StateMatrix = Eigen::Matrix<double, S, S>;
  using InputMatrix = Eigen::Matrix<double, S, U>;
  using Vector = Eigen::Matrix<double, V, 1>;
  using Matrix = Eigen::Matrix<double, V, V>;

  using Values = std::array<double, C>;  // of one interval's constraints, their slacks or their multipliers
  using CurvedRows = Eigen::Matrix<double, curved_rows, V, Eigen::RowMajor>;

  // Six rows in whole vectors: two more that do not count.
  using StateColumns = Eigen::Matrix<double, V, S>;
  using ToMiddle = Eigen::Matrix<double, V, V + 1>;

  struct Stage {        // largest alignment first
    Matrix hessian;     // of the Lagrangian and the barrier, by z in the middle
    CurvedRows row_by;  // gradients of the constraints from first_curved_row on, in typical sizes
    Vector gradient;    // of cost and barrier
    // The step in the middle of the interval is T w = M x + N u + m for w = (x, u, 1), at its end 2 T w - x.
    ToMiddle to_middle;                 // T = (M, N, m)
    StateColumns to_middle_transposed;  // M'
    StateColumns P;                     // cost to go at its first node
    Eigen::Matrix<double, U, S> K;
    StateVector q;
    Eigen::Matrix<double, U, 1> k;
    StateVector defect;  // of the dynamics
    Values c;            // the constraints
    double cost = 0, mu = 0;
    double n_stiff = 0, n_force = 0;  // of the barrier of n at its second node
  };
  /// Of a node, in typical sizes.
  struct NodeStep {
    Vector middle_step;  // of state and input, half-way to the next node
    StateVector dx;
    Eigen::Matrix<double, U, 1> du;
    StateVector pi;  // multipliers after a full step
    Values dt, dlambda;
  };
  /// What a search weighs: cost and barrier, the sum of all violations, and that with a penalty for each.
  struct Trial {
    double objective = 0, violation = 0, penalised = 0;
    double merit() const { return objective + penalised; }
  };

  std::size_t index(std::size_t k) const { return (first_ + k) % problem().size(); }
  void middle(const std::vector<WindowNode>& lap, std::size_t k, double share, double (&z)[V]) const;

  void set_barriers(double mu);
  void evaluate(std::vector<WindowNode>& lap, std::size_t k);
  void start_constraints(WindowNode& node, const Stage& stage) const;
  void add_constraints(const WindowNode& node, Stage& stage) const;
  /// mu / t + lambda / t (c + t): the force of every constraint's barrier, and lambda / t, its stiffness.
  struct Barriers {
    Values force, stiff;
  };
  static Barriers barriers(const WindowNode& node, const Stage& stage);
  void measure_defect(const std::vector<WindowNode>& lap, WindowStep& result) const;
  void eliminate(const std::vector<WindowNode>& lap, std::size_t k);
  bool factorise();
  /// Second and first derivatives by state and input.
  struct CostToGo {
    StateMatrix xx;
    InputMatrix xu;
    Eigen::Matrix<double, U, U> uu;
    StateVector x;
    Eigen::Matrix<double, U, 1> u;
  };
  CostToGo cost_to_go(const Stage& stage, const StateColumns& P, const StateVector& q, double delta) const;
  static bool take_best_input(const CostToGo& cost, Stage& stage);
  bool backward(double delta);
  void forward();
  void steps_of_constraints(const std::vector<WindowNode>& lap);
  void measure_change(WindowStep& result) const;
  void follow_penalties(const std::vector<WindowNode>& lap, double defect);
  void count(Trial& trial, const StateVector& defect, const Values& c, const Values& t) const;
  void count_ends(Trial& trial, double share) const;
  Trial here(const std::vector<WindowNode>& lap) const;
  Trial after(const std::vector<WindowNode>& lap, double share);
  double search(const std::vector<WindowNode>& lap);
  void advance(std::vector<WindowNode>& lap, double share);

  IntervalProgram program_;
  std::array<double, V> scale_;
  IntervalDerivatives derivatives_;  // of the interval that is evaluated
  std::size_t first_ = 0, count_ = 0;
  double mu_ = 0, delta_ = 0;
  std::array<double, S> state_penalty_{};  // of violations of the dynamics and of the constraints in the merit
  std::array<double, C> row_penalty_{};
  std::array<double, V> begin_{}, end_{};
  std::vector<Stage> stages_;  // one more than intervals, as all of these
  std::vector<NodeStep> step_;
  std::vector<Values> trial_t_;  // slacks where after() looked last
  TrialFilter filter_;           // of this window at its barrier
  bool filter_is_old_ = true;
};

}  // namespace gripline::time_optimal
