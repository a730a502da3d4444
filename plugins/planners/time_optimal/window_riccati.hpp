// The quadratic program of a Newton step (window_solver.hpp): the dynamics eliminated interval by interval, and a
// Riccati recursion over the nodes. Source: Rao, Wright, Rawlings (1998), "Application of interior-point methods to
// model predictive control".
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "planners/time_optimal/window_newton.hpp"

namespace gripline::time_optimal {

class WindowRiccati {
 public:
  /// Half of the gradients of an interval's step by state and input.
  using HalfRates = Eigen::Matrix<double, lap_states, lap_variables, Eigen::RowMajor>;

  /// For windows of up to `nodes` intervals.
  explicit WindowRiccati(std::size_t nodes);

  /// Eliminates the linearised dynamics of interval k: the step in its middle by state and input. `defect` is the
  /// window model's.
  void eliminate(std::size_t k, const HalfRates& half, const StateVector& defect);
  /// The defect of state j, as far as the end of the interval is away from where the dynamics lead.
  double defect_at_end(std::size_t k, int j) const { return 2.0 * stages_[k].to_middle(j, lap_variables); }
  /// Sets the step of the window's first node, with as much curvature added as the recursion needs; false where none is
  /// enough.
  bool factorise(WindowModel& window);
  /// Steps of the nodes after the first, of inputs and of multipliers.
  void forward(WindowModel& window) const;
  /// Adds curvature to the next factorise(), for a more cautious step: where no share of the last one was better.
  void add_curvature();

 private:
  // Six rows in whole vectors: two more that do not count.
  using ToMiddle = Eigen::Matrix<double, lap_variables, lap_variables + 1>;
  using InputMatrix = Eigen::Matrix<double, lap_states, lap_inputs>;
  struct Stage {  // largest alignment first
    // The step in the middle of the interval is T w = M x + N u + m for w = (x, u, 1), at its end 2 T w - x.
    ToMiddle to_middle;                 // T = (M, N, m)
    StateColumns to_middle_transposed;  // M'
    StateColumns P;                     // cost to go at its first node
    Eigen::Matrix<double, lap_inputs, lap_states> K;
    StateVector q;
    InputVector k;
  };
  /// Second and first derivatives by state and input.
  struct CostToGo {
    Eigen::Matrix<double, lap_states, lap_states> xx;
    InputMatrix xu;
    Eigen::Matrix<double, lap_inputs, lap_inputs> uu;
    StateVector x;
    InputVector u;
  };
  static CostToGo cost_to_go(const IntervalModel& model, const Stage& stage, const StateColumns& P,
                             const StateVector& q, double delta);
  static bool take_best_input(const CostToGo& cost, Stage& stage);
  bool backward(WindowModel& window, double delta);

  double delta_ = 0;           // curvature that was added
  std::vector<Stage> stages_;  // one more than intervals
};

}  // namespace gripline::time_optimal
