// How much of a Newton step of a window is taken (window_solver.hpp): the first share, halved from 1, that lowers a
// merit function or that a filter of trial points takes. The merit is cost and barrier, and a penalty of its own for
// every state's dynamics and every kind of constraint, as large as their own multipliers ask for.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "planners/time_optimal/interval_program.hpp"
#include "planners/time_optimal/trial_filter.hpp"
#include "planners/time_optimal/window_newton.hpp"

namespace gripline::time_optimal {

class WindowSearch {
 public:
  /// For windows of up to `nodes` intervals.
  explicit WindowSearch(std::size_t nodes) : slacks_(nodes + 1) {}

  /// Forgets the trial points: they are of another window, program, barrier or iterate than the next one.
  void forget() { filter_is_old_ = true; }
  /// The share that is taken, 0 where none is better. `defect` is the iterate's.
  double search(const IntervalProgram& program, const WindowModel& window, const std::vector<WindowNode>& lap,
                double defect);
  /// Slacks of interval k after the share that was looked at last.
  const RowValues& slacks(std::size_t k) const { return slacks_[k]; }

 private:
  /// What is weighed: cost and barrier, the sum of all violations, and that with a penalty for each.
  struct Trial {
    double objective = 0, violation = 0, penalised = 0;
    double merit() const { return objective + penalised; }
  };
  void follow_penalties(bool shares_friction, const WindowModel& window, const std::vector<WindowNode>& lap,
                        double defect);
  Trial here(const WindowModel& window, const std::vector<WindowNode>& lap) const;
  Trial after(const IntervalProgram& program, const WindowModel& window, const std::vector<WindowNode>& lap,
              double share);
  static void take_slacks(const WindowNode& node, const NodeStep& step, double share, const RowValues* c, RowValues& t);
  void count(Trial& trial, const StateVector& defect, const RowValues& c, const RowValues& t) const;
  static void count_ends(const WindowModel& window, double share, Trial& trial);

  std::array<double, lap_states> state_penalty_{};  // of violations of the dynamics and of the constraints
  RowValues row_penalty_{};
  std::vector<RowValues> slacks_;
  TrialFilter filter_;
  bool filter_is_old_ = true;
};

}  // namespace gripline::time_optimal
