#include "planners/time_optimal/window_solver.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

namespace gripline::time_optimal {
namespace {

static_assert(lap_states == 6 && lap_variables == 8, "rows below are padded to whole vectors");

/// Rows of a system of six equations and of its right-hand sides, in whole vectors.
using System = Eigen::Matrix<double, 6, 16, Eigen::RowMajor>;

/// Solves for all right-hand sides, which stand behind the six columns of the matrix, by elimination with row pivots: six
/// rows are too few for a library's blocked kernels. Not finite where the matrix is singular.
void eliminate_rows(System& rows) {
  constexpr int n = 6;
  // Columns that are done are not looked at again: `left` are those that count.
  const auto eliminate = [&rows](int k, auto left) {
    int pivot = k;
    for (int i = k + 1; i < n; ++i)
      if (std::abs(rows(i, k)) > std::abs(rows(pivot, k))) pivot = i;
    const auto row = [&](int i) { return rows.row(i).template tail<left>(); };
    if (pivot != k) row(k).swap(row(pivot));
    row(k) *= 1.0 / rows(k, k);
    for (int i = 0; i < n; ++i)
      if (i != k) row(i) -= rows(i, k) * row(k);
  };
  for (int k = 0; k < 4; ++k) eliminate(k, std::integral_constant<int, 16>{});
  for (int k = 4; k < n; ++k) eliminate(k, std::integral_constant<int, 12>{});
}

/// A B for A with six columns and rows in whole vectors; rows of B from the seventh on do not count.
template <int n>
Eigen::Matrix<double, 8, n> product(const Eigen::Matrix<double, 8, 6>& A, const Eigen::Matrix<double, 8, n>& B) {
  Eigen::Matrix<double, 8, n> C;
  for (int j = 0; j < n; ++j) {
    Eigen::Matrix<double, 8, 1> sum = A.col(0) * B(0, j);
    for (int i = 1; i < 6; ++i) sum += A.col(i) * B(i, j);
    C.col(j) = sum;
  }
  return C;
}

/// All constraints of an interval but its last one, in whole vectors.
using FirstRows = Eigen::Array<double, 16, 1>;
constexpr std::size_t last_row = interval_rows - 1;
static_assert(last_row == 16);
Eigen::Map<const FirstRows> first_rows(const std::array<double, interval_rows>& rows) {
  return Eigen::Map<const FirstRows>(rows.data());
}
Eigen::Map<FirstRows> first_rows(std::array<double, interval_rows>& rows) { return Eigen::Map<FirstRows>(rows.data()); }

/// One logarithm instead of 17: slacks are far from the ends of a double's range.
double log_of_product(const std::array<double, interval_rows>& t) {
  return std::log(first_rows(t).prod() * t[last_row]);
}

constexpr double first_delta = 1e-4;  // curvature that is added where the program is not convex

}  // namespace

WindowSolver::WindowSolver(const LapProblem& problem, std::size_t nodes)
    : program_(problem), scale_(program_.scales()), stages_(nodes + 1), step_(nodes + 1), trial_t_(nodes + 1) {
  for (Stage& stage : stages_) {
    stage.to_middle.setZero();  // rows beyond the states stay so
    stage.to_middle_transposed.setZero();
  }
}

void WindowSolver::set_car(const AxleTyres& tyres, const SpecificResistance& more) {
  program_.set_car(tyres, more);
  filter_is_old_ = true;
}

void WindowSolver::set_grip(std::size_t node, double grip) {
  program_.set_grip(node, grip);
  filter_is_old_ = true;
}

void WindowSolver::middle(const std::vector<WindowNode>& lap, std::size_t k, double share, double (&z)[V]) const {
  const WindowNode &here = lap[index(k)], &there = lap[index(k + 1)];
  for (int j = 0; j < V; ++j) {
    const auto i = static_cast<std::size_t>(j);
    z[j] = j < S ? 0.5 * (here.z[i] + there.z[i]) : here.z[i];
    if (share != 0.0)
      z[j] += share * scale_[i] * (j < S ? 0.5 * (step_[k].dx[j] + step_[k + 1].dx[j]) : step_[k].du[j - S]);
  }
}

/// That of a window, and what it rises to over its last quarter.
void WindowSolver::set_barriers(double mu) {
  const std::size_t near = near_part(count_);
  const double rise = std::max(1.0, end_barrier / mu);
  for (std::size_t k = 0; k < count_; ++k)
    stages_[k].mu =
        k < near ? mu : mu * std::pow(rise, static_cast<double>(k + 1 - near) / static_cast<double>(count_ - near));
}

void WindowSolver::start_constraints(WindowNode& node, const Stage& stage) const {
  for (std::size_t i = 0; i < node.t.size(); ++i) {
    node.t[i] = std::max(-stage.c[i], 1e-2);
    node.lambda[i] = stage.mu / node.t[i];
  }
  node.started = true;
}

WindowSolver::Barriers WindowSolver::barriers(const WindowNode& node, const Stage& stage) {
  Barriers b;
  first_rows(b.stiff) = first_rows(node.lambda) / first_rows(node.t);
  first_rows(b.force) =
      stage.mu / first_rows(node.t) + first_rows(b.stiff) * (first_rows(stage.c) + first_rows(node.t));
  const double t = node.t[last_row];
  b.stiff[last_row] = node.lambda[last_row] / t;
  b.force[last_row] = stage.mu / t + b.stiff[last_row] * (stage.c[last_row] + t);
  return b;
}

/// The barrier of an interval, eliminated: lambda+ = mu / t + lambda / t (c + t + dc).
void WindowSolver::add_constraints(const WindowNode& node, Stage& stage) const {
  const auto [force, stiff] = barriers(node, stage);
  stage.n_stiff = stiff[n_most] + stiff[n_least];
  stage.n_force = force[n_most] - force[n_least];
  for (std::size_t i = mid_most; i < first_curved_row; ++i) {
    const LinearRow& row = linear_row[i];
    stage.gradient[row.variable] += force[i] * row.slope;
    stage.hessian(row.variable, row.variable) += stiff[i];
  }
  for (int i = 0; i < curved_rows; ++i) {
    const std::size_t at = static_cast<std::size_t>(first_curved_row) + static_cast<std::size_t>(i);
    const Vector by = stage.row_by.row(i).transpose();
    stage.gradient += force[at] * by;
    stage.hessian.noalias() += (stiff[at] * by) * by.transpose();
  }
}

void WindowSolver::evaluate(std::vector<WindowNode>& lap, std::size_t k) {
  const std::size_t i = index(k);
  WindowNode& node = lap[i];
  Stage& stage = stages_[k];
  double z[V];
  middle(lap, k, 0.0, z);
  std::array<double, S> rate_weight{};
  for (std::size_t j = 0; j < rate_weight.size(); ++j) rate_weight[j] = -node.pi[j] * problem().ds[i] / scale_[j];
  std::array<double, curved_rows> row_weight{};
  if (node.started) std::copy(node.lambda.begin() + first_curved_row, node.lambda.end(), row_weight.begin());
  program_.differentiate(i, z, rate_weight, row_weight, derivatives_);

  stage.cost = derivatives_.cost;
  program_.linear_rows(i, z, lap[index(k + 1)].z[lap_n],
                       [&](int row, double value) { stage.c[static_cast<std::size_t>(row)] = value; });
  std::copy(derivatives_.row.begin(), derivatives_.row.end(), stage.c.begin() + first_curved_row);
  const auto scaled = [this](const std::array<double, V>& by) {
    return Vector::Map(by.data()).cwiseProduct(Vector::Map(scale_.data()));
  };
  stage.gradient = scaled(derivatives_.cost_by);
  for (int row = 0; row < curved_rows; ++row)
    stage.row_by.row(row) = scaled(derivatives_.row_by[static_cast<std::size_t>(row)]).transpose();
  std::size_t entry = 0;
  for (int a = 0; a < V; ++a) {
    const double unit = scale_[static_cast<std::size_t>(a)];
    for (int b = 0; b <= a; ++b, ++entry)
      stage.hessian(a, b) = stage.hessian(b, a) =
          derivatives_.lagrangian_by[entry] * unit * scale_[static_cast<std::size_t>(b)];
  }
  if (!node.started) {
    start_constraints(node, stage);
    filter_is_old_ = true;  // what was tried was of another iterate
  }
  first_rows(node.t) = first_rows(node.t).max(-first_rows(stage.c));
  node.t[last_row] = std::max(node.t[last_row], -stage.c[last_row]);
  add_constraints(node, stage);
  eliminate(lap, k);
}

/// (I - F / 2) x+ = (I + F / 2) x + G u - defect, F and G the gradients of the step by x and by u: the middle of both ends
/// is x + (F (x + x+) + G u - defect) / 2, so that (I - F / 2) (M, N, m) = (I, G / 2, -defect / 2).
void WindowSolver::eliminate(const std::vector<WindowNode>& lap, std::size_t k) {
  Stage& stage = stages_[k];
  const std::size_t at = index(k);
  const WindowNode &here = lap[at], &there = lap[index(k + 1)];
  System rows = System::Zero();
  for (int j = 0; j < S; ++j) {
    const auto i = static_cast<std::size_t>(j);
    const double step = problem().ds[at] / scale_[i];
    stage.defect[j] = (there.z[i] - here.z[i]) / scale_[i] - step * derivatives_.rate[i];
    const Vector half =
        (0.5 * step * Vector::Map(scale_.data())).cwiseProduct(Vector::Map(derivatives_.rate_by[i].data()));
    rows.row(j).head<S>() = -half.head<S>().transpose();
    rows.row(j).segment<U>(2 * S) = half.tail<U>().transpose();
    rows(j, j) += 1.0;
    rows(j, S + j) = 1.0;
    rows(j, S + V) = -0.5 * stage.defect[j];
  }
  eliminate_rows(rows);
  stage.to_middle.topRows<S>() = rows.block<S, V + 1>(0, S);
  stage.to_middle_transposed.topRows<S>() = rows.block<S, S>(0, S).transpose();
}

/// The cost to go from a stage's first node, by w = (x, u, 1): with the middle y = T w and the next node 2 y - x it is
///   (y, u)' H (y, u) / 2 + g' (y, u) + (2 y - x)' P (2 y - x) / 2 + q' (2 y - x).
/// Its second derivatives by x are M' X M - 2 (M' P + P M) + P with X = Hyy + 4 P; the first three terms are W' M + M' W
/// for W = X M / 2 - 2 P. `delta` is added to every second derivative by an input or a state.
WindowSolver::CostToGo WindowSolver::cost_to_go(const Stage& s, const StateColumns& P, const StateVector& q,
                                                double delta) const {
  StateColumns X = s.hessian.leftCols<S>() + 4.0 * P;  // its last rows: by input and state
  for (int j = 0; j < S; ++j) X(j, j) += delta;
  const ToMiddle XT = product(X, s.to_middle);
  const auto N = s.to_middle.block<S, U>(0, S);
  const Eigen::Matrix<double, 8, U + 1> Nm = s.to_middle.rightCols<U + 1>(), PNm = product(P, Nm);
  CostToGo Q;
  const StateColumns W = 0.5 * XT.leftCols<S>() - 2.0 * P;
  const StateColumns MW = product(s.to_middle_transposed, W);
  for (int j = 0; j < S; ++j)
    for (int i = 0; i <= j; ++i) Q.xx(i, j) = Q.xx(j, i) = MW(i, j) + MW(j, i) + P(i, j);
  Eigen::Matrix<double, 8, U + 1> by = XT.rightCols<U + 1>();
  by.topLeftCorner<S, U>() += s.hessian.topRightCorner<S, U>();
  by.col(U).head<S>() += s.gradient.head<S>() + 2.0 * q;
  const Eigen::Matrix<double, 8, U + 1> onward = product(s.to_middle_transposed, by);
  Q.xu = onward.topLeftCorner<S, U>() - 2.0 * PNm.topLeftCorner<S, U>();
  Q.x = onward.col(U).head<S>() - 2.0 * PNm.col(U).head<S>() - q;
  const Eigen::Matrix2d crossed = XT.block<U, U>(S, S);
  Q.uu = N.transpose() * XT.block<S, U>(0, S) + crossed + crossed.transpose() + s.hessian.bottomRightCorner<U, U>();
  Q.uu.diagonal().array() += delta;
  Q.u = N.transpose() * by.col(U).head<S>() + XT.block<U, 1>(S, V) + s.gradient.tail<U>();
  return Q;
}

/// The input that is best for every state of a stage's first node; false where none is.
bool WindowSolver::take_best_input(const CostToGo& Q, Stage& s) {
  const double det = Q.uu(0, 0) * Q.uu(1, 1) - Q.uu(0, 1) * Q.uu(1, 0);
  if (!(Q.uu(0, 0) > 1e-9) || !(det > 1e-9 * Q.uu(0, 0) * std::max(Q.uu(1, 1), 1e-9))) return false;
  Eigen::Matrix2d inverse;
  inverse << Q.uu(1, 1), -Q.uu(0, 1), -Q.uu(1, 0), Q.uu(0, 0);
  inverse /= det;
  s.K.noalias() = -inverse * Q.xu.transpose();
  s.k.noalias() = -inverse * Q.u;
  return true;
}

/// The recursion; false where the program is not convex along the dynamics. `delta`: as in cost_to_go().
bool WindowSolver::backward(double delta) {
  StateColumns P = StateColumns::Zero();
  P.topRows<S>().diagonal().setConstant(end_weight);
  StateVector q;
  for (int j = 0; j < S; ++j) q[j] = end_weight * end_[static_cast<std::size_t>(j)];
  const auto add_node = [&](const Stage& before) {  // a node's own constraints belong to the interval before it
    P(lap_n, lap_n) += before.n_stiff;
    q[lap_n] += before.n_force;
  };
  add_node(stages_[count_ - 1]);
  for (std::size_t k = count_; k-- > 0;) {
    Stage& s = stages_[k];
    stages_[k + 1].P = P;
    stages_[k + 1].q = q;
    const CostToGo Q = cost_to_go(s, P, q, delta);
    if (!take_best_input(Q, s)) return false;
    for (int j = 0; j < S; ++j)
      for (int i = 0; i <= j; ++i) P(i, j) = P(j, i) = Q.xx(i, j) + Q.xu.row(i).dot(s.K.col(j));
    q = Q.x + Q.xu * s.k;
    if (k > 0) add_node(stages_[k - 1]);
  }
  for (int j = 0; j < S; ++j) {
    P(j, j) += begin_weight;
    q[j] += begin_weight * begin_[static_cast<std::size_t>(j)];
  }
  const Eigen::LLT<StateMatrix> factor(P.topRows<S>());
  if (factor.info() != Eigen::Success) return false;
  step_[0].dx = -factor.solve(q);
  return step_[0].dx.allFinite();
}

void WindowSolver::forward() {
  for (std::size_t k = 0; k < count_; ++k) {
    const Stage& s = stages_[k];
    NodeStep& step = step_[k];
    StateVector& next = step_[k + 1].dx;
    step.du = s.K * step.dx + s.k;
    Eigen::Matrix<double, V + 1, 1> w;
    w << step.dx, step.du, 1.0;
    step.middle_step = s.to_middle * w;
    step.middle_step.tail<U>() = step.du;
    next = 2.0 * step.middle_step.head<S>() - step.dx;
    const Vector along = s.hessian * step.middle_step + delta_ * step.middle_step + s.gradient;
    Vector costate = stages_[k + 1].P * next;
    costate.head<S>() += stages_[k + 1].q + 0.5 * along.head<S>();
    step.pi = -(s.to_middle_transposed * costate.head<S>()).head<S>();
  }
}

/// Steps of slacks and multipliers.
void WindowSolver::steps_of_constraints(const std::vector<WindowNode>& lap) {
  for (std::size_t k = 0; k < count_; ++k) {
    const WindowNode& node = lap[index(k)];
    const Vector& step = step_[k].middle_step;
    const double next = step_[k + 1].dx[lap_n];
    Values by;
    for (int i = 0; i < C; ++i) {
      const auto at = static_cast<std::size_t>(i);
      if (i >= first_curved_row)
        by[at] = stages_[k].row_by.row(i - first_curved_row).dot(step);
      else
        by[at] = linear_row[at].slope * (i <= n_least ? next : step[linear_row[at].variable]);
    }
    const auto set = [mu = stages_[k].mu](const auto& t, const auto& lambda, const auto& c, const auto& change,
                                          auto&& dt, auto&& dlambda) {
      dt = -(c + t) - change;
      dlambda = mu / t - lambda - lambda / t * dt;
    };
    const Values& c = stages_[k].c;
    Values &dt = step_[k].dt, &dlambda = step_[k].dlambda;
    set(first_rows(node.t), first_rows(node.lambda), first_rows(c), first_rows(by), first_rows(dt),
        first_rows(dlambda));
    set(node.t[last_row], node.lambda[last_row], c[last_row], by[last_row], dt[last_row], dlambda[last_row]);
  }
}

void WindowSolver::measure_change(WindowStep& result) const {
  for (std::size_t k = 0; k < count_; ++k) {
    result.change = std::max(result.change, step_[k].middle_step.lpNorm<Eigen::Infinity>());
    if (k < near_part(count_)) result.near_change = result.change;
  }
}

/// Penalties of the merit follow the multipliers of this step. `defect` is the iterate's.
void WindowSolver::follow_penalties(const std::vector<WindowNode>& lap, double defect) {
  std::array<double, S> state_force{};
  std::array<double, C> row_force{};
  for (std::size_t k = 0; k < count_; ++k) {
    const WindowNode& node = lap[index(k)];
    for (std::size_t i = 0; i < node.t.size(); ++i)
      row_force[i] = std::max(row_force[i], node.lambda[i] + step_[k].dlambda[i]);
    for (std::size_t i = 0; i < state_force.size(); ++i)
      state_force[i] = std::max(state_force[i], std::abs(step_[k].pi[static_cast<Eigen::Index>(i)]));
  }
  const auto follow = [](auto& penalty, const auto& force) {
    for (std::size_t i = 0; i < penalty.size(); ++i) penalty[i] = std::max(1.2 * force[i], 0.5 * penalty[i]);
  };
  // Far from the dynamics, and where nothing but the dynamics is curved, the largest of all multipliers counts.
  constexpr double far = 0.05;
  const double state_most = *std::max_element(state_force.begin(), state_force.end());
  if (!program_.shares_friction()) {
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
void WindowSolver::count(Trial& trial, const StateVector& defect, const Values& c, const Values& t) const {
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

void WindowSolver::count_ends(Trial& trial, double share) const {
  for (int j = 0; j < S; ++j) {
    const auto m = static_cast<std::size_t>(j);
    const double from = begin_[m] + share * step_[0].dx[j], to = end_[m] + share * step_[count_].dx[j];
    trial.objective += 0.5 * (begin_weight * from * from + end_weight * to * to);
  }
}

/// Of the iterate, from what evaluate() found.
WindowSolver::Trial WindowSolver::here(const std::vector<WindowNode>& lap) const {
  Trial trial;
  for (std::size_t k = 0; k < count_; ++k) {
    const Stage& stage = stages_[k];
    const WindowNode& node = lap[index(k)];
    trial.objective += stage.cost - stage.mu * log_of_product(node.t);
    count(trial, stage.defect, stage.c, node.t);
  }
  count_ends(trial, 0.0);
  return trial;
}

/// Of the iterate after a share of the step.
WindowSolver::Trial WindowSolver::after(const std::vector<WindowNode>& lap, double share) {
  const bool curved = program_.shares_friction();
  Trial trial;
  for (std::size_t k = 0; k < count_; ++k) {
    const std::size_t i = index(k);
    double z[V];
    middle(lap, k, share, z);
    const LapRates<double> r = program_.rates(i, z);
    const WindowNode &node = lap[i], &there = lap[index(k + 1)];
    StateVector defect;
    for (int j = 0; j < S; ++j) {
      const auto m = static_cast<std::size_t>(j);
      const double rise = (there.z[m] - node.z[m]) / scale_[m] + share * (step_[k + 1].dx[j] - step_[k].dx[j]);
      defect[j] = rise - problem().ds[i] / scale_[m] * r.state[j];
    }
    Values c;
    const auto put = [&c](int row, double value) { c[static_cast<std::size_t>(row)] = value; };
    program_.linear_rows(i, z, there.z[lap_n] + share * scale_[lap_n] * step_[k + 1].dx[lap_n], put);
    program_.curved_rows_of(i, z, r, put);
    Values& t = trial_t_[k];
    const Values& dt = step_[k].dt;
    first_rows(t) = (first_rows(node.t) + share * first_rows(dt)).max(0.02 * first_rows(node.t)).max(1e-5);
    t[last_row] = std::max({node.t[last_row] + share * dt[last_row], 0.02 * node.t[last_row], 1e-5});
    if (curved) {  // a slack is what its constraint leaves, where that is not much less than the step says
      first_rows(t) = (-first_rows(c) > 0.1 * first_rows(t)).select(-first_rows(c), first_rows(t));
      if (-c[last_row] > 0.1 * t[last_row]) t[last_row] = -c[last_row];
    }
    trial.objective += program_.cost(i, z, r) - stages_[k].mu * log_of_product(t);
    count(trial, defect, c, t);
  }
  count_ends(trial, share);
  return trial;
}

/// The share of the step that lowers the merit or that the filter takes, 0 where none does.
double WindowSolver::search(const std::vector<WindowNode>& lap) {
  constexpr double most_violation = 10.0;
  constexpr int trials = 5;
  const Trial before = here(lap);
  if (filter_is_old_) filter_.clear(std::max(most_violation, 2.0 * before.violation));
  filter_is_old_ = false;
  double share = 1.0;
  for (int i = 0; i < trials; ++i, share *= 0.5) {
    const Trial trial = after(lap, share);
    if (!std::isfinite(trial.merit())) continue;
    if (trial.merit() <= before.merit() + 1e-9 * std::abs(before.merit())) return share;
    if (filter_.take({before.violation, before.objective}, {trial.violation, trial.objective})) return share;
  }
  return 0.0;
}

void WindowSolver::advance(std::vector<WindowNode>& lap, double share) {
  constexpr double spread = 100.0;  // of slack times multiplier about the barrier
  for (std::size_t k = 0; k <= count_; ++k) {
    WindowNode& node = lap[index(k)];
    for (int j = 0; j < S; ++j)
      node.z[static_cast<std::size_t>(j)] += share * scale_[static_cast<std::size_t>(j)] * step_[k].dx[j];
    if (k == count_) break;
    for (int j = S; j < V; ++j)
      node.z[static_cast<std::size_t>(j)] += share * scale_[static_cast<std::size_t>(j)] * step_[k].du[j - S];
    for (int j = 0; j < S; ++j) {
      double& pi = node.pi[static_cast<std::size_t>(j)];
      pi += share * (step_[k].pi[j] - pi);
    }
    for (std::size_t i = 0; i < node.t.size(); ++i) {
      node.t[i] = trial_t_[k][i];
      const double central = stages_[k].mu / node.t[i];
      node.lambda[i] = std::clamp(node.lambda[i] + share * step_[k].dlambda[i], central / spread, central * spread);
    }
  }
}

void WindowSolver::measure_defect(const std::vector<WindowNode>& lap, WindowStep& result) const {
  const auto add = [&result](double violation) {
    result.defect = std::isfinite(violation) ? std::max(result.defect, std::abs(violation))
                                             : std::numeric_limits<double>::infinity();
  };
  for (std::size_t k = 0; k < count_; ++k) {
    const WindowNode& node = lap[index(k)];
    const FirstRows wrong = (first_rows(stages_[k].c) + first_rows(node.t)).abs();
    add((wrong < std::numeric_limits<double>::infinity()).all() ? wrong.maxCoeff()
                                                                : std::numeric_limits<double>::infinity());
    add(stages_[k].c[last_row] + node.t[last_row]);
    for (int j = 0; j < S; ++j) add(2.0 * stages_[k].to_middle(j, V));
    if (k < near_part(count_)) result.near_defect = result.defect;
  }
}

/// The recursion, with as much curvature added as it needs.
bool WindowSolver::factorise() {
  constexpr double most = 1e6;
  double delta = delta_ > first_delta ? delta_ / 3.0 : 0.0;
  while (!backward(delta)) {
    delta = delta > 0 ? 4.0 * delta : first_delta;
    if (delta > most) {
      delta_ = 0;
      return false;
    }
  }
  delta_ = delta;
  return true;
}

WindowStep WindowSolver::iterate(std::vector<WindowNode>& lap, std::size_t first, std::size_t count, double mu,
                                 const std::array<double, lap_variables>& begin,
                                 const std::array<double, lap_variables>& end) {
  count = std::min(count, stages_.size() - 1);
  if (first != first_ || count != count_ || mu != mu_) filter_is_old_ = true;
  first_ = first;
  count_ = count;
  mu_ = mu;
  WindowStep result;
  for (std::size_t j = 0; j < begin_.size(); ++j) {
    begin_[j] = (lap[index(0)].z[j] - begin[j]) / scale_[j];
    end_[j] = (lap[index(count_)].z[j] - end[j]) / scale_[j];
  }
  set_barriers(mu);
  for (std::size_t k = 0; k < count_; ++k) evaluate(lap, k);
  measure_defect(lap, result);  // also of an iterate that stays as it is
  if (!factorise()) return result;
  forward();
  steps_of_constraints(lap);
  measure_change(result);
  if (!std::isfinite(result.change)) return result;
  follow_penalties(lap, result.defect);
  result.share = search(lap);
  result.good = result.share > 0.0;
  if (result.good)
    advance(lap, result.share);
  else  // where no share of the step is better, a more cautious one is looked for next time
    delta_ = std::clamp(10.0 * delta_, 10.0 * first_delta, 1.0);
  return result;
}

}  // namespace gripline::time_optimal
