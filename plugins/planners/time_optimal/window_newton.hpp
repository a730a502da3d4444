// What the parts of a window's Newton step share (window_solver.hpp): the iterate, the program's local model at each
// interval, and the step. All in typical sizes.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "planners/time_optimal/interval_program.hpp"

namespace gripline::time_optimal {

inline constexpr int lap_inputs = lap_variables - lap_states;
static_assert(lap_states == 6 && lap_variables == 8, "matrices here are padded to whole vectors");

using StateVector = Eigen::Matrix<double, lap_states, 1>;
using InputVector = Eigen::Matrix<double, lap_inputs, 1>;
using VariableVector = Eigen::Matrix<double, lap_variables, 1>;
using VariableMatrix = Eigen::Matrix<double, lap_variables, lap_variables>;
using StateColumns = Eigen::Matrix<double, lap_variables, lap_states>;  // six rows in whole vectors: two do not count
using LapVariables = std::array<double, lap_variables>;

/// A number for each constraint of an interval: its value, its slack or its multiplier.
using RowValues = std::array<double, interval_rows>;
/// All of them but the last, in whole vectors.
using FirstRows = Eigen::Array<double, 16, 1>;
inline constexpr std::size_t last_row = interval_rows - 1;
static_assert(last_row == 16);
inline Eigen::Map<const FirstRows> first_rows(const RowValues& rows) {
  return Eigen::Map<const FirstRows>(rows.data());
}
inline Eigen::Map<FirstRows> first_rows(RowValues& rows) { return Eigen::Map<FirstRows>(rows.data()); }

/// A node of the iterate: the lap's variables there, multipliers of the dynamics to the next node, and slack and
/// multiplier of every constraint.
struct WindowNode {
  LapVariables z{};
  std::array<double, lap_states> pi{};
  RowValues t{}, lambda{};
  bool started = false;  // slacks and multipliers are of an iterate
};

/// Gradients of the constraints from first_curved_row on.
using CurvedRows = Eigen::Matrix<double, curved_rows, lap_variables, Eigen::RowMajor>;

/// The program at an interval of the iterate. Largest alignment first.
struct IntervalModel {
  VariableMatrix hessian;  // of the Lagrangian and the barrier, by z in the middle
  CurvedRows row_by;
  VariableVector gradient;  // of cost and barrier
  StateVector defect;       // of the dynamics
  RowValues c;              // the constraints
  double cost = 0;
  double mu = 0;                    // of its barrier
  double n_stiff = 0, n_force = 0;  // of the barrier of n at its second node
};

/// The Newton step of a node.
struct NodeStep {
  VariableVector middle_step;  // of state and input, half-way to the next node
  StateVector dx;
  InputVector du;
  StateVector pi;  // multipliers after a full step
  RowValues dt, dlambda;
};

/// The window that an iteration works on.
struct WindowModel {
  static constexpr double begin_weight = 1000.0, end_weight = 100.0;  // [s] per squared typical size

  /// For windows of up to `nodes` intervals.
  explicit WindowModel(std::size_t nodes) : intervals(nodes + 1), step(nodes + 1) {}
  std::size_t index(std::size_t k) const { return (first + k) % lap_size; }

  std::size_t lap_size = 1, first = 0, count = 0;
  LapVariables scale{};         // typical sizes
  LapVariables begin{}, end{};  // what the iterate's ends are away from where they should be
  std::vector<IntervalModel> intervals;
  std::vector<NodeStep> step;
};

/// The variables in the middle of an interval, after a share of the step.
inline void middle_of(const WindowModel& window, const std::vector<WindowNode>& lap, std::size_t k, double share,
                      double (&z)[lap_variables]) {
  const WindowNode &here = lap[window.index(k)], &there = lap[window.index(k + 1)];
  for (int j = 0; j < lap_variables; ++j) {
    const auto i = static_cast<std::size_t>(j);
    const bool state = j < lap_states;
    z[j] = state ? 0.5 * (here.z[i] + there.z[i]) : here.z[i];
    if (share != 0.0)
      z[j] += share * window.scale[i] *
              (state ? 0.5 * (window.step[k].dx[j] + window.step[k + 1].dx[j]) : window.step[k].du[j - lap_states]);
  }
}

}  // namespace gripline::time_optimal
