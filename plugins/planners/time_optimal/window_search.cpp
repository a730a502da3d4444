#include "planners/time_optimal/window_search.hpp"

#include <algorithm>
#include <cmath>

namespace gripline::time_optimal {
namespace {

/// One logarithm instead of 17: slacks are far from the ends of a double's range.
double log_of_product(const RowValues& t) { return std::log(first_rows(t).prod() * t[last_row]); }

}  // namespace

/// Penalties of the merit follow the multipliers of this step. `defect` is the iterate's.
void WindowSearch::follow_penalties(bool shares_friction, const WindowModel& window, const std::vector<WindowNode>& lap,
                                    double defect) {
  std::array<double, lap_states> state_force{};
  RowValues row_force{};
  for (std::size_t k = 0; k < window.count; ++k) {
    const WindowNode& node = lap[window.index(k)];
    for (std::size_t i = 0; i < node.t.size(); ++i)
      row_force[i] = std::max(row_force[i], node.lambda[i] + window.step[k].dlambda[i]);
    for (std::size_t i = 0; i < state_force.size(); ++i)
      state_force[i] = std::max(state_force[i], std::abs(window.step[k].pi[static_cast<Eigen::Index>(i)]));
  }
  const auto follow = [](auto& penalty, const auto& force) {
    for (std::size_t i = 0; i < penalty.size(); ++i) penalty[i] = std::max(1.2 * force[i], 0.5 * penalty[i]);
  };
  // Far from the dynamics, and where nothing but the dynamics is curved, the largest of all multipliers counts.
  constexpr double far = 0.05;
  const double state_most = *std::max_element(state_force.begin(), state_force.end());
  if (!shares_friction) {
    const double most = std::max(state_most, *std::max_element(row_force.begin(), row_force.end()));
    state_force.fill(most);
    row_force.fill(most);
  } else if (defect > far) {
    state_force.fill(state_most);
  }
  follow(state_penalty_, state_force);
  follow(row_penalty_, row_force);
}

/// An interval's violations.
void WindowSearch::count(Trial& trial, const StateVector& defect, const RowValues& c, const RowValues& t) const {
  for (std::size_t j = 0; j < state_penalty_.size(); ++j) {
    const double wrong = std::abs(defect[static_cast<Eigen::Index>(j)]);
    trial.violation += wrong;
    trial.penalised += state_penalty_[j] * wrong;
  }
  const FirstRows wrong = (first_rows(c) + first_rows(t)).abs();
  const double last = std::abs(c[last_row] + t[last_row]);
  trial.violation += wrong.sum() + last;
  trial.penalised += (first_rows(row_penalty_) * wrong).sum() + row_penalty_[last_row] * last;
}

void WindowSearch::count_ends(const WindowModel& window, double share, Trial& trial) {
  for (int j = 0; j < lap_states; ++j) {
    const auto m = static_cast<std::size_t>(j);
    const double from = window.begin[m] + share * window.step[0].dx[j],
                 to = window.end[m] + share * window.step[window.count].dx[j];
    trial.objective += 0.5 * (WindowModel::begin_weight * from * from + WindowModel::end_weight * to * to);
  }
}

/// Objective, violation and penalties of the iterate, from its model.
WindowSearch::Trial WindowSearch::here(const WindowModel& window, const std::vector<WindowNode>& lap) const {
  Trial trial;
  for (std::size_t k = 0; k < window.count; ++k) {
    const IntervalModel& model = window.intervals[k];
    const WindowNode& node = lap[window.index(k)];
    trial.objective += model.cost - model.mu * log_of_product(node.t);
    count(trial, model.defect, model.c, node.t);
  }
  count_ends(window, 0.0, trial);
  return trial;
}

/// After a share of the step: no slack falls by more than to a fiftieth. Where constraints are curved along a step
/// (`c`, else null) a slack is what its constraint leaves, if that is not much less than the step says.
void WindowSearch::take_slacks(const WindowNode& node, const NodeStep& step, double share, const RowValues* c,
                               RowValues& t) {
  constexpr double least_share = 0.02, least = 1e-5, much_less = 0.1;
  first_rows(t) = (first_rows(node.t) + share * first_rows(step.dt)).max(least_share * first_rows(node.t)).max(least);
  t[last_row] = std::max({node.t[last_row] + share * step.dt[last_row], least_share * node.t[last_row], least});
  if (c == nullptr) return;
  first_rows(t) = (-first_rows(*c) > much_less * first_rows(t)).select(-first_rows(*c), first_rows(t));
  if (-(*c)[last_row] > much_less * t[last_row]) t[last_row] = -(*c)[last_row];
}

/// Objective, violation and penalties after a share of the step, where the program is evaluated anew.
WindowSearch::Trial WindowSearch::after(const IntervalProgram& program, const WindowModel& window,
                                        const std::vector<WindowNode>& lap, double share) {
  Trial trial;
  for (std::size_t k = 0; k < window.count; ++k) {
    const std::size_t i = window.index(k);
    double z[lap_variables];
    middle_of(window, lap, k, share, z);
    const LapRates<double> r = program.rates(i, z);
    const WindowNode &node = lap[i], &there = lap[window.index(k + 1)];
    const NodeStep &step = window.step[k], &next = window.step[k + 1];
    StateVector defect;
    for (int j = 0; j < lap_states; ++j) {
      const auto m = static_cast<std::size_t>(j);
      const double rise = (there.z[m] - node.z[m]) / window.scale[m] + share * (next.dx[j] - step.dx[j]);
      defect[j] = rise - program.problem().ds[i] / window.scale[m] * r.state[j];
    }
    RowValues c;
    const auto put = [&c](int row, double value) { c[static_cast<std::size_t>(row)] = value; };
    program.linear_rows(i, z, there.z[lap_n] + share * window.scale[lap_n] * next.dx[lap_n], put);
    program.curved_rows_of(i, z, r, put);
    take_slacks(node, step, share, program.shares_friction() ? &c : nullptr, slacks_[k]);
    trial.objective += program.cost(i, z, r) - window.intervals[k].mu * log_of_product(slacks_[k]);
    count(trial, defect, c, slacks_[k]);
  }
  count_ends(window, share, trial);
  return trial;
}

double WindowSearch::search(const IntervalProgram& program, const WindowModel& window,
                            const std::vector<WindowNode>& lap, double defect) {
  constexpr double most_violation = 10.0;
  constexpr int trials = 5;
  follow_penalties(program.shares_friction(), window, lap, defect);
  const Trial before = here(window, lap);
  if (filter_is_old_) filter_.clear(std::max(most_violation, 2.0 * before.violation));
  filter_is_old_ = false;
  double share = 1.0;
  for (int i = 0; i < trials; ++i, share *= 0.5) {
    const Trial trial = after(program, window, lap, share);
    if (!std::isfinite(trial.merit())) continue;
    if (trial.merit() <= before.merit() + 1e-9 * std::abs(before.merit())) return share;
    if (filter_.take({before.violation, before.objective}, {trial.violation, trial.objective})) return share;
  }
  return 0.0;
}

}  // namespace gripline::time_optimal
