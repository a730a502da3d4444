#include "planners/time_optimal/window_solver.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace gripline::time_optimal {
namespace {

/// The inverse, by elimination with row pivots: six rows are too few for a library's blocked kernels.
Eigen::Matrix<double, 6, 6> inverse_of(Eigen::Matrix<double, 6, 6> m) {
  constexpr int n = 6;
  Eigen::Matrix<double, n, n> inverse = Eigen::Matrix<double, n, n>::Identity();
  for (int k = 0; k < n; ++k) {
    int pivot = k;
    for (int i = k + 1; i < n; ++i)
      if (std::abs(m(i, k)) > std::abs(m(pivot, k))) pivot = i;
    if (pivot != k) {
      m.row(k).swap(m.row(pivot));
      inverse.row(k).swap(inverse.row(pivot));
    }
    const double per = 1.0 / m(k, k);
    m.row(k) *= per;
    inverse.row(k) *= per;
    for (int i = 0; i < n; ++i) {
      if (i == k) continue;
      const double by = m(i, k);
      m.row(i) -= by * m.row(k);
      inverse.row(i) -= by * inverse.row(k);
    }
  }
  return inverse;
}

}  // namespace

WindowSolver::WindowSolver(const LapProblem& problem, std::size_t nodes)
    : program_(problem), scale_(program_.scales()), stages_(nodes + 1), dt_(nodes), dlambda_(nodes), t_(nodes) {}

void WindowSolver::middle(const std::vector<WindowNode>& lap, std::size_t k, double share, double (&z)[V]) const {
  const WindowNode &here = lap[index(k)], &there = lap[index(k + 1)];
  for (int j = 0; j < V; ++j) {
    const auto i = static_cast<std::size_t>(j);
    z[j] = j < S ? 0.5 * (here.z[i] + there.z[i]) : here.z[i];
    if (share != 0.0)
      z[j] += share * scale_[i] * (j < S ? 0.5 * (stages_[k].dx[j] + stages_[k + 1].dx[j]) : stages_[k].du[j - S]);
  }
}

void WindowSolver::start_constraints(WindowNode& node, const Constraints& c) const {
  for (std::size_t i = 0; i < node.t.size(); ++i) {
    node.t[i] = std::max(-c.value[i], 1e-2);
    node.lambda[i] = mu_ / node.t[i];
  }
  node.started = true;
}

WindowSolver::Barrier WindowSolver::barrier(const WindowNode& node, const Stage& stage, int row) const {
  const auto at = static_cast<std::size_t>(row);
  const double stiff = node.lambda[at] / node.t[at];
  return {mu_ / node.t[at] + stiff * (stage.c.value[at] + node.t[at]), stiff};
}

/// The barrier of an interval, eliminated: lambda+ = mu / t + lambda / t (c + t + dc).
void WindowSolver::add_constraints(const WindowNode& node, Stage& stage) const {
  const Barrier most = barrier(node, stage, n_most), least = barrier(node, stage, n_least);
  stage.n_stiff = most.stiff + least.stiff;
  stage.n_force = most.force - least.force;
  for (int i = mid_most; i < C; ++i) {
    const Barrier one = barrier(node, stage, i);
    const Vector by = stage.c.by.row(i).transpose();
    stage.gradient += one.force * by;
    stage.hessian.noalias() += (one.stiff * by) * by.transpose();
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

  for (std::size_t m = 0; m < scale_.size(); ++m)
    stage.gradient[static_cast<Eigen::Index>(m)] = derivatives_.cost[m] * scale_[m];
  program_.linear_rows(i, z, lap[index(k + 1)].z[lap_n], [&](int row, double value, int by, double slope) {
    stage.c.value[static_cast<std::size_t>(row)] = value;
    if (by >= 0) stage.c.by(row, by) = slope;
  });
  for (std::size_t row = 0; row < derivatives_.row.size(); ++row) {
    stage.c.value[row + first_curved_row] = derivatives_.row[row];
    for (std::size_t m = 0; m < scale_.size(); ++m)
      stage.c.by(static_cast<Eigen::Index>(row) + first_curved_row, static_cast<Eigen::Index>(m)) =
          derivatives_.row_by[row][m] * scale_[m];
  }
  if (!node.started) start_constraints(node, stage.c);

  std::size_t entry = 0;
  for (int a = 0; a < V; ++a)
    for (int b = 0; b <= a; ++b, ++entry)
      stage.hessian(a, b) = stage.hessian(b, a) =
          derivatives_.lagrangian_by[entry] * scale_[static_cast<std::size_t>(a)] * scale_[static_cast<std::size_t>(b)];
  add_constraints(node, stage);
  eliminate(lap, k);
}

/// (I - F / 2) x+ = (I + F / 2) x + G u - defect, F and G the gradients of the step by x and by u.
void WindowSolver::eliminate(const std::vector<WindowNode>& lap, std::size_t k) {
  Stage& stage = stages_[k];
  const std::size_t at = index(k);
  const WindowNode &here = lap[at], &there = lap[index(k + 1)];
  StateVector defect;
  StateMatrix implicit;
  InputMatrix G;
  for (int j = 0; j < S; ++j) {
    const auto i = static_cast<std::size_t>(j);
    const double step = problem().ds[at] / scale_[i];
    defect[j] = (there.z[i] - here.z[i]) / scale_[i] - step * derivatives_.rate[i];
    for (int m = 0; m < S; ++m) {
      const auto n = static_cast<std::size_t>(m);
      implicit(j, m) = (j == m ? 1.0 : 0.0) - 0.5 * step * scale_[n] * derivatives_.rate_by[i][n];
    }
    for (int m = S; m < V; ++m) {
      const auto n = static_cast<std::size_t>(m);
      G(j, m - S) = step * scale_[n] * derivatives_.rate_by[i][n];
    }
  }
  stage.inverse = inverse_of(implicit);
  stage.A = 2.0 * stage.inverse - StateMatrix::Identity();  // (I - F / 2)^-1 (I + F / 2)
  stage.B.noalias() = stage.inverse.lazyProduct(G);
  stage.b.noalias() = -stage.inverse.lazyProduct(defect);
}

/// The recursion; false where the program is not convex along the dynamics. `delta` is added to every second
/// derivative by an input or a state.
bool WindowSolver::backward(double delta) {
  StateMatrix P = StateMatrix::Identity() * end_weight;
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
    Matrix T = Matrix::Zero();
    T.topLeftCorner<S, S>() = 0.5 * (StateMatrix::Identity() + s.A);
    T.topRightCorner<S, 2>() = 0.5 * s.B;
    T(S, S) = T(S + 1, S + 1) = 1.0;
    Vector t = Vector::Zero();
    t.head<S>() = 0.5 * s.b;
    Matrix H = s.hessian;
    H.diagonal().array() += delta;
    const Matrix HT = H * T;
    Matrix Y = T.transpose() * HT;
    Vector y = T.transpose() * (s.gradient + H * t);
    Eigen::Matrix<double, S, V> AB;
    AB << s.A, s.B;
    const Eigen::Matrix<double, S, V> PAB = P * AB;
    Y.noalias() += AB.transpose() * PAB;
    y.noalias() += AB.transpose() * (P * s.b + q);
    const Eigen::Matrix2d Quu = Y.bottomRightCorner<2, 2>();
    const double det = Quu(0, 0) * Quu(1, 1) - Quu(0, 1) * Quu(1, 0);
    if (!(Quu(0, 0) > 1e-9) || !(det > 1e-9 * Quu(0, 0) * std::max(Quu(1, 1), 1e-9))) return false;
    Eigen::Matrix2d inverse;
    inverse << Quu(1, 1), -Quu(0, 1), -Quu(1, 0), Quu(0, 0);
    inverse /= det;
    s.K.noalias() = -inverse * Y.bottomLeftCorner<2, S>();
    s.k.noalias() = -inverse * y.tail<2>();
    P = Y.topLeftCorner<S, S>() + Y.topRightCorner<S, 2>() * s.K;
    P = (0.5 * (P + P.transpose())).eval();
    q = y.head<S>() + Y.topRightCorner<S, 2>() * s.k;
    if (k > 0) add_node(stages_[k - 1]);
  }
  for (int j = 0; j < S; ++j) {
    P(j, j) += begin_weight;
    q[j] += begin_weight * begin_[static_cast<std::size_t>(j)];
  }
  const Eigen::LLT<StateMatrix> factor(P);
  if (factor.info() != Eigen::Success) return false;
  stages_[0].P = P;
  stages_[0].q = q;
  stages_[0].dx = -factor.solve(q);
  return stages_[0].dx.allFinite();
}

WindowSolver::Vector WindowSolver::middle_step(std::size_t k) const {
  Vector step;
  step.head<S>() = 0.5 * (stages_[k].dx + stages_[k + 1].dx);
  step.tail<2>() = stages_[k].du;
  return step;
}

void WindowSolver::forward() {
  for (std::size_t k = 0; k < count_; ++k) {
    Stage& s = stages_[k];
    s.du = s.K * s.dx + s.k;
    stages_[k + 1].dx = s.A * s.dx + s.B * s.du + s.b;
    const Vector along = s.hessian * middle_step(k) + s.gradient;
    const StateVector costate = stages_[k + 1].P * stages_[k + 1].dx + stages_[k + 1].q;
    s.pi = -s.inverse.transpose() * (costate + 0.5 * along.head<S>());
  }
}

/// Steps of slacks and multipliers.
void WindowSolver::steps_of_constraints(const std::vector<WindowNode>& lap) {
  for (std::size_t k = 0; k < count_; ++k) {
    const WindowNode& node = lap[index(k)];
    const Vector step = middle_step(k);
    const double next = stages_[k + 1].dx[lap_n];
    for (int i = 0; i < C; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double by = i == n_most ? next : i == n_least ? -next : stages_[k].c.by.row(i).dot(step);
      const double t = node.t[at], lambda = node.lambda[at];
      dt_[k][at] = -(stages_[k].c.value[at] + t) - by;
      dlambda_[k][at] = mu_ / t - lambda - lambda / t * dt_[k][at];
    }
  }
}

double WindowSolver::merit(const std::vector<WindowNode>& lap, double share) {
  const bool curved = program_.shares_friction();
  double sum = 0, wrong = 0, barrier = 0;
  for (std::size_t k = 0; k < count_; ++k) {
    double slacks = 1.0;  // their product: far from the ends of a double's range, and one logarithm instead of 17
    const std::size_t i = index(k);
    double z[V];
    middle(lap, k, share, z);
    const LapRates<double> r = program_.rates(i, z);
    sum += program_.cost(i, z, r);
    const WindowNode &here = lap[i], &there = lap[index(k + 1)];
    for (int j = 0; j < S; ++j) {
      const auto m = static_cast<std::size_t>(j);
      const double rise = (there.z[m] - here.z[m]) / scale_[m] + share * (stages_[k + 1].dx[j] - stages_[k].dx[j]);
      wrong += state_penalty_[m] * std::abs(rise - problem().ds[i] / scale_[m] * r.state[j]);
    }
    const auto add = [&](int row, double value) {
      const auto at = static_cast<std::size_t>(row);
      double t = here.t[at];
      if (share != 0.0) {
        t = kept_positive(t, share * dt_[k][at]);
        // A slack is what its constraint leaves, where that is not much less than the step says.
        if (curved && -value > 0.1 * t) t = -value;
      }
      if (share != 0.0) t_[k][at] = t;
      slacks *= t;
      wrong += row_penalty_[at] * std::abs(value + t);
    };
    const double n_next = there.z[lap_n] + share * scale_[lap_n] * stages_[k + 1].dx[lap_n];
    program_.linear_rows(i, z, n_next, [&](int row, double value, int, double) { add(row, value); });
    program_.curved_rows_of(i, z, r, add);
    barrier += std::log(slacks);
  }
  for (int j = 0; j < S; ++j) {
    const auto m = static_cast<std::size_t>(j);
    const double from = begin_[m] + share * stages_[0].dx[j], to = end_[m] + share * stages_[count_].dx[j];
    sum += 0.5 * (begin_weight * from * from + end_weight * to * to);
  }
  return sum - mu_ * barrier + wrong;
}

void WindowSolver::advance(std::vector<WindowNode>& lap, double share) {
  constexpr double spread = 100.0;  // of slack times multiplier about the barrier
  for (std::size_t k = 0; k <= count_; ++k) {
    WindowNode& node = lap[index(k)];
    for (int j = 0; j < S; ++j)
      node.z[static_cast<std::size_t>(j)] += share * scale_[static_cast<std::size_t>(j)] * stages_[k].dx[j];
    if (k == count_) break;
    for (int j = S; j < V; ++j)
      node.z[static_cast<std::size_t>(j)] += share * scale_[static_cast<std::size_t>(j)] * stages_[k].du[j - S];
    for (int j = 0; j < S; ++j) {
      double& pi = node.pi[static_cast<std::size_t>(j)];
      pi += share * (stages_[k].pi[j] - pi);
    }
    for (std::size_t i = 0; i < node.t.size(); ++i) {
      node.t[i] = t_[k][i];
      const double central = mu_ / node.t[i];
      node.lambda[i] = std::clamp(node.lambda[i] + share * dlambda_[k][i], central / spread, central * spread);
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
    for (std::size_t i = 0; i < node.t.size(); ++i) add(stages_[k].c.value[i] + node.t[i]);
    for (int j = 0; j < S; ++j) add(stages_[k].b[j]);
    if (k < near_part(count_)) result.near_defect = result.defect;
  }
}

WindowStep WindowSolver::iterate(std::vector<WindowNode>& lap, std::size_t first, std::size_t count, double mu,
                                 const std::array<double, lap_variables>& begin,
                                 const std::array<double, lap_variables>& end) {
  first_ = first;
  count_ = std::min(count, stages_.size() - 1);
  mu_ = mu;
  WindowStep result;
  for (std::size_t j = 0; j < begin_.size(); ++j) {
    begin_[j] = (lap[index(0)].z[j] - begin[j]) / scale_[j];
    end_[j] = (lap[index(count_)].z[j] - end[j]) / scale_[j];
  }
  for (std::size_t k = 0; k < count_; ++k) evaluate(lap, k);
  measure_defect(lap, result);  // also of an iterate that stays as it is
  constexpr double first_delta = 1e-4, most = 1e6;
  double delta = delta_ > first_delta ? delta_ / 3.0 : 0.0;
  while (!backward(delta)) {
    delta = delta > 0 ? 4.0 * delta : first_delta;
    if (delta > most) {
      delta_ = 0;
      return result;
    }
  }
  delta_ = delta;
  forward();
  steps_of_constraints(lap);

  std::array<double, S> state_force{};
  std::array<double, C> row_force{};
  for (std::size_t k = 0; k < count_; ++k) {
    result.change = std::max(result.change, middle_step(k).lpNorm<Eigen::Infinity>());
    const WindowNode& node = lap[index(k)];
    for (std::size_t i = 0; i < node.t.size(); ++i)
      row_force[i] = std::max(row_force[i], node.lambda[i] + dlambda_[k][i]);
    for (std::size_t i = 0; i < state_force.size(); ++i)
      state_force[i] = std::max(state_force[i], std::abs(stages_[k].pi[static_cast<Eigen::Index>(i)]));
    if (k < near_part(count_)) result.near_change = result.change;
  }
  if (!std::isfinite(result.change)) return result;
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
  } else if (result.defect > far) {
    state_force.fill(state_most);
  }
  follow(state_penalty_, state_force);
  follow(row_penalty_, row_force);
  const double before = merit(lap, 0.0);
  double share = 1.0;
  constexpr int trials = 5;
  for (int trial = 0; trial < trials; ++trial, share *= 0.5) {
    const double after = merit(lap, share);
    if (std::isfinite(after) && after <= before + 1e-9 * std::abs(before)) {
      advance(lap, share);
      result.share = share;
      result.good = true;
      return result;
    }
  }
  // Where no share of the step is better, a more cautious one is looked for next time.
  delta_ = std::clamp(10.0 * delta_, 10.0 * first_delta, 1.0);
  return result;
}

}  // namespace gripline::time_optimal
