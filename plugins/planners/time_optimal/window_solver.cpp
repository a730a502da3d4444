#include "planners/time_optimal/window_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gripline::time_optimal {
namespace {

constexpr int S = lap_states, V = lap_variables;

}  // namespace

WindowSolver::WindowSolver(const LapProblem& problem, std::size_t nodes)
    : program_(problem), window_(nodes), riccati_(nodes), search_(nodes) {
  window_.lap_size = problem.size();
  window_.scale = program_.scales();
}

void WindowSolver::set_car(const AxleTyres& tyres, const SpecificResistance& more) {
  program_.set_car(tyres, more);
  search_.forget();
}

void WindowSolver::set_grip(std::size_t node, double grip) {
  program_.set_grip(node, grip);
  search_.forget();
}

/// Sets the intervals' barriers: `mu`, rising to end_barrier over the last quarter of the window.
void WindowSolver::set_barriers(double mu) {
  const std::size_t near = near_part(window_.count);
  const double rise = std::max(1.0, end_barrier / mu);
  for (std::size_t k = 0; k < window_.count; ++k)
    window_.intervals[k].mu =
        k < near ? mu
                 : mu * std::pow(rise, static_cast<double>(k + 1 - near) / static_cast<double>(window_.count - near));
}

void WindowSolver::start_constraints(WindowNode& node, const IntervalModel& model) {
  for (std::size_t i = 0; i < node.t.size(); ++i) {
    node.t[i] = std::max(-model.c[i], 1e-2);
    node.lambda[i] = model.mu / node.t[i];
  }
  node.started = true;
}

WindowSolver::Barriers WindowSolver::barriers(const WindowNode& node, const IntervalModel& model) {
  Barriers b;
  first_rows(b.stiff) = first_rows(node.lambda) / first_rows(node.t);
  first_rows(b.force) =
      model.mu / first_rows(node.t) + first_rows(b.stiff) * (first_rows(model.c) + first_rows(node.t));
  const double t = node.t[last_row];
  b.stiff[last_row] = node.lambda[last_row] / t;
  b.force[last_row] = model.mu / t + b.stiff[last_row] * (model.c[last_row] + t);
  return b;
}

/// The barrier of an interval, eliminated: lambda+ = mu / t + lambda / t (c + t + dc).
void WindowSolver::add_constraints(const WindowNode& node, IntervalModel& model) {
  const auto [force, stiff] = barriers(node, model);
  model.n_stiff = stiff[n_most] + stiff[n_least];
  model.n_force = force[n_most] - force[n_least];
  for (std::size_t i = mid_most; i < first_curved_row; ++i) {
    const LinearRow& row = linear_row[i];
    model.gradient[row.variable] += force[i] * row.slope;
    model.hessian(row.variable, row.variable) += stiff[i];
  }
  for (int i = 0; i < curved_rows; ++i) {
    const std::size_t at = static_cast<std::size_t>(first_curved_row) + static_cast<std::size_t>(i);
    const VariableVector by = model.row_by.row(i).transpose();
    model.gradient += force[at] * by;
    model.hessian.noalias() += (stiff[at] * by) * by.transpose();
  }
}

void WindowSolver::evaluate(std::vector<WindowNode>& lap, std::size_t k) {
  const std::size_t i = window_.index(k);
  WindowNode& node = lap[i];
  const WindowNode& there = lap[window_.index(k + 1)];
  const LapVariables& scale = window_.scale;
  double z[V];
  middle_of(window_, lap, k, 0.0, z);
  std::array<double, S> rate_weight{};
  for (std::size_t j = 0; j < rate_weight.size(); ++j) rate_weight[j] = -node.pi[j] * problem().ds[i] / scale[j];
  std::array<double, curved_rows> row_weight{};
  if (node.started) std::copy(node.lambda.begin() + first_curved_row, node.lambda.end(), row_weight.begin());
  program_.differentiate(i, z, rate_weight, row_weight, derivatives_);

  IntervalModel& model = window_.intervals[k];
  program_.linear_rows(i, z, there.z[lap_n],
                       [&](int row, double value) { model.c[static_cast<std::size_t>(row)] = value; });
  set_model(derivatives_, model);
  if (!node.started) {
    start_constraints(node, model);
    search_.forget();  // what was tried was of another iterate
  }
  first_rows(node.t) = first_rows(node.t).max(-first_rows(model.c));
  node.t[last_row] = std::max(node.t[last_row], -model.c[last_row]);
  add_constraints(node, model);
  eliminate(node, there, i, k);
}

/// Takes an interval's derivatives over into its model, in typical sizes, without the constraints' barriers.
void WindowSolver::set_model(const IntervalDerivatives& d, IntervalModel& model) const {
  const LapVariables& scale = window_.scale;
  const auto scaled = [&scale](const LapVariables& by) {
    return VariableVector::Map(by.data()).cwiseProduct(VariableVector::Map(scale.data()));
  };
  model.cost = d.cost;
  std::copy(d.row.begin(), d.row.end(), model.c.begin() + first_curved_row);
  model.gradient = scaled(d.cost_by);
  for (int row = 0; row < curved_rows; ++row)
    model.row_by.row(row) = scaled(d.row_by[static_cast<std::size_t>(row)]).transpose();
  std::size_t entry = 0;
  for (int a = 0; a < V; ++a) {
    const double unit = scale[static_cast<std::size_t>(a)];
    for (int b = 0; b <= a; ++b, ++entry)
      model.hessian(a, b) = model.hessian(b, a) = d.lagrangian_by[entry] * unit * scale[static_cast<std::size_t>(b)];
  }
}

/// The dynamics of interval k, which is the lap's interval i.
void WindowSolver::eliminate(const WindowNode& here, const WindowNode& there, std::size_t i, std::size_t k) {
  const LapVariables& scale = window_.scale;
  StateVector& defect = window_.intervals[k].defect;
  WindowRiccati::HalfRates half;
  for (int j = 0; j < S; ++j) {
    const auto m = static_cast<std::size_t>(j);
    const double step = problem().ds[i] / scale[m];
    defect[j] = (there.z[m] - here.z[m]) / scale[m] - step * derivatives_.rate[m];
    half.row(j) = (0.5 * step * VariableVector::Map(scale.data()))
                      .cwiseProduct(VariableVector::Map(derivatives_.rate_by[m].data()))
                      .transpose();
  }
  riccati_.eliminate(k, half, defect);
}

/// Steps of slacks and multipliers.
void WindowSolver::steps_of_constraints(const std::vector<WindowNode>& lap) {
  for (std::size_t k = 0; k < window_.count; ++k) {
    const WindowNode& node = lap[window_.index(k)];
    const VariableVector& step = window_.step[k].middle_step;
    const double next = window_.step[k + 1].dx[lap_n];
    RowValues by;
    for (int i = 0; i < interval_rows; ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (i >= first_curved_row)
        by[at] = window_.intervals[k].row_by.row(i - first_curved_row).dot(step);
      else
        by[at] = linear_row[at].slope * (i <= n_least ? next : step[linear_row[at].variable]);
    }
    const auto set = [mu = window_.intervals[k].mu](const auto& t, const auto& lambda, const auto& c,
                                                    const auto& change, auto&& dt, auto&& dlambda) {
      dt = -(c + t) - change;
      dlambda = mu / t - lambda - lambda / t * dt;
    };
    const RowValues& c = window_.intervals[k].c;
    RowValues &dt = window_.step[k].dt, &dlambda = window_.step[k].dlambda;
    set(first_rows(node.t), first_rows(node.lambda), first_rows(c), first_rows(by), first_rows(dt),
        first_rows(dlambda));
    set(node.t[last_row], node.lambda[last_row], c[last_row], by[last_row], dt[last_row], dlambda[last_row]);
  }
}

void WindowSolver::measure_change(WindowStep& result) const {
  for (std::size_t k = 0; k < window_.count; ++k) {
    result.change = std::max(result.change, window_.step[k].middle_step.lpNorm<Eigen::Infinity>());
    if (k < near_part(window_.count)) result.near_change = result.change;
  }
}

void WindowSolver::advance(std::vector<WindowNode>& lap, double share) {
  constexpr double spread = 100.0;  // of slack times multiplier about the barrier
  for (std::size_t k = 0; k <= window_.count; ++k) {
    WindowNode& node = lap[window_.index(k)];
    for (int j = 0; j < S; ++j)
      node.z[static_cast<std::size_t>(j)] += share * window_.scale[static_cast<std::size_t>(j)] * window_.step[k].dx[j];
    if (k == window_.count) break;
    for (int j = S; j < V; ++j)
      node.z[static_cast<std::size_t>(j)] +=
          share * window_.scale[static_cast<std::size_t>(j)] * window_.step[k].du[j - S];
    for (int j = 0; j < S; ++j) {
      double& pi = node.pi[static_cast<std::size_t>(j)];
      pi += share * (window_.step[k].pi[j] - pi);
    }
    for (std::size_t i = 0; i < node.t.size(); ++i) {
      node.t[i] = search_.slacks(k)[i];
      const double central = window_.intervals[k].mu / node.t[i];
      node.lambda[i] =
          std::clamp(node.lambda[i] + share * window_.step[k].dlambda[i], central / spread, central * spread);
    }
  }
}

void WindowSolver::measure_defect(const std::vector<WindowNode>& lap, WindowStep& result) const {
  const auto add = [&result](double violation) {
    result.defect = std::isfinite(violation) ? std::max(result.defect, std::abs(violation))
                                             : std::numeric_limits<double>::infinity();
  };
  for (std::size_t k = 0; k < window_.count; ++k) {
    const WindowNode& node = lap[window_.index(k)];
    const FirstRows wrong = (first_rows(window_.intervals[k].c) + first_rows(node.t)).abs();
    add((wrong < std::numeric_limits<double>::infinity()).all() ? wrong.maxCoeff()
                                                                : std::numeric_limits<double>::infinity());
    add(window_.intervals[k].c[last_row] + node.t[last_row]);
    for (int j = 0; j < S; ++j) add(riccati_.defect_at_end(k, j));
    if (k < near_part(window_.count)) result.near_defect = result.defect;
  }
}

WindowStep WindowSolver::iterate(std::vector<WindowNode>& lap, std::size_t first, std::size_t count, double mu,
                                 const LapVariables& begin, const LapVariables& end) {
  count = std::min(count, window_.intervals.size() - 1);
  if (first != window_.first || count != window_.count || mu != mu_) search_.forget();
  window_.first = first;
  window_.count = count;
  mu_ = mu;
  WindowStep result;
  for (std::size_t j = 0; j < begin.size(); ++j) {
    window_.begin[j] = (lap[window_.index(0)].z[j] - begin[j]) / window_.scale[j];
    window_.end[j] = (lap[window_.index(count)].z[j] - end[j]) / window_.scale[j];
  }
  set_barriers(mu);
  for (std::size_t k = 0; k < count; ++k) evaluate(lap, k);
  measure_defect(lap, result);  // also of an iterate that stays as it is
  if (!riccati_.factorise(window_)) return result;
  riccati_.forward(window_);
  steps_of_constraints(lap);
  measure_change(result);
  if (!std::isfinite(result.change)) return result;
  result.share = search_.search(program_, window_, lap, result.defect);
  result.good = result.share > 0.0;
  if (result.good)
    advance(lap, result.share);
  else  // where no share of the step is better, a more cautious one is looked for next time
    riccati_.add_curvature();
  return result;
}

}  // namespace gripline::time_optimal
