#include "planners/time_optimal/window_riccati.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "planners/time_optimal/small_dense.hpp"

namespace gripline::time_optimal {
namespace {

constexpr int S = lap_states, V = lap_variables, U = lap_inputs;
constexpr double first_delta = 1e-4;  // curvature that is added where the program is not convex

}  // namespace

WindowRiccati::WindowRiccati(std::size_t nodes) : stages_(nodes + 1) {
  for (Stage& stage : stages_) {
    stage.to_middle.setZero();  // rows beyond the states stay so
    stage.to_middle_transposed.setZero();
  }
}

/// (I - F / 2) x+ = (I + F / 2) x + G u - defect, F and G the gradients of the step by x and by u: the middle of both
/// ends is x + (F (x + x+) + G u - defect) / 2, so that (I - F / 2) (M, N, m) = (I, G / 2, -defect / 2).
void WindowRiccati::eliminate(std::size_t k, const HalfRates& half, const StateVector& defect) {
  SixEquations rows = SixEquations::Zero();
  for (int j = 0; j < S; ++j) {
    rows.row(j).head<S>() = -half.row(j).head<S>();
    rows.row(j).segment<U>(2 * S) = half.row(j).tail<U>();
    rows(j, j) += 1.0;
    rows(j, S + j) = 1.0;
    rows(j, S + V) = -0.5 * defect[j];
  }
  eliminate_rows(rows);
  stages_[k].to_middle.topRows<S>() = rows.block<S, V + 1>(0, S);
  stages_[k].to_middle_transposed.topRows<S>() = rows.block<S, S>(0, S).transpose();
}

/// The cost to go from a stage's first node, by w = (x, u, 1): with the middle y = T w and the next node 2 y - x it is
///   (y, u)' H (y, u) / 2 + g' (y, u) + (2 y - x)' P (2 y - x) / 2 + q' (2 y - x).
/// Its second derivatives by x are M' X M - 2 (M' P + P M) + P with X = Hyy + 4 P; the first three terms are W' M + M'
/// W for W = X M / 2 - 2 P. `delta` is added to every second derivative by an input or a state.
WindowRiccati::CostToGo WindowRiccati::cost_to_go(const IntervalModel& model, const Stage& s, const StateColumns& P,
                                                  const StateVector& q, double delta) {
  StateColumns X = model.hessian.leftCols<S>() + 4.0 * P;  // its last rows: by input and state
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
  by.topLeftCorner<S, U>() += model.hessian.topRightCorner<S, U>();
  by.col(U).head<S>() += model.gradient.head<S>() + 2.0 * q;
  const Eigen::Matrix<double, 8, U + 1> onward = product(s.to_middle_transposed, by);
  Q.xu = onward.topLeftCorner<S, U>() - 2.0 * PNm.topLeftCorner<S, U>();
  Q.x = onward.col(U).head<S>() - 2.0 * PNm.col(U).head<S>() - q;
  const Eigen::Matrix2d crossed = XT.block<U, U>(S, S);
  Q.uu = N.transpose() * XT.block<S, U>(0, S) + crossed + crossed.transpose() + model.hessian.bottomRightCorner<U, U>();
  Q.uu.diagonal().array() += delta;
  Q.u = N.transpose() * by.col(U).head<S>() + XT.block<U, 1>(S, V) + model.gradient.tail<U>();
  return Q;
}

/// The input that is best for every state of a stage's first node; false where none is.
bool WindowRiccati::take_best_input(const CostToGo& Q, Stage& s) {
  const double det = Q.uu(0, 0) * Q.uu(1, 1) - Q.uu(0, 1) * Q.uu(1, 0);
  if (!(Q.uu(0, 0) > 1e-9) || !(det > 1e-9 * Q.uu(0, 0) * std::max(Q.uu(1, 1), 1e-9))) return false;
  Eigen::Matrix2d inverse;
  inverse << Q.uu(1, 1), -Q.uu(0, 1), -Q.uu(1, 0), Q.uu(0, 0);
  inverse /= det;
  s.K.noalias() = -inverse * Q.xu.transpose();
  s.k.noalias() = -inverse * Q.u;
  return true;
}

bool WindowRiccati::factorise(WindowModel& window) {
  constexpr double most = 1e6;
  double delta = delta_ > first_delta ? delta_ / 3.0 : 0.0;
  while (!backward(window, delta)) {
    delta = delta > 0 ? 4.0 * delta : first_delta;
    if (delta > most) {
      delta_ = 0;
      return false;
    }
  }
  delta_ = delta;
  return true;
}

/// The recursion; false where the program is not convex along the dynamics. `delta`: as in cost_to_go().
bool WindowRiccati::backward(WindowModel& window, double delta) {
  StateColumns P = StateColumns::Zero();
  P.topRows<S>().diagonal().setConstant(WindowModel::end_weight);
  StateVector q;
  for (int j = 0; j < S; ++j) q[j] = WindowModel::end_weight * window.end[static_cast<std::size_t>(j)];
  const auto add_node = [&](const IntervalModel& before) {  // a node's own constraints belong to the interval before it
    P(lap_n, lap_n) += before.n_stiff;
    q[lap_n] += before.n_force;
  };
  add_node(window.intervals[window.count - 1]);
  for (std::size_t k = window.count; k-- > 0;) {
    Stage& s = stages_[k];
    stages_[k + 1].P = P;
    stages_[k + 1].q = q;
    const CostToGo Q = cost_to_go(window.intervals[k], s, P, q, delta);
    if (!take_best_input(Q, s)) return false;
    for (int j = 0; j < S; ++j)
      for (int i = 0; i <= j; ++i) P(i, j) = P(j, i) = Q.xx(i, j) + Q.xu.row(i).dot(s.K.col(j));
    q = Q.x + Q.xu * s.k;
    if (k > 0) add_node(window.intervals[k - 1]);
  }
  for (int j = 0; j < S; ++j) {
    P(j, j) += WindowModel::begin_weight;
    q[j] += WindowModel::begin_weight * window.begin[static_cast<std::size_t>(j)];
  }
  const Eigen::LLT<Eigen::Matrix<double, S, S>> factor(P.topRows<S>());
  if (factor.info() != Eigen::Success) return false;
  window.step[0].dx = -factor.solve(q);
  return window.step[0].dx.allFinite();
}

void WindowRiccati::forward(WindowModel& window) const {
  for (std::size_t k = 0; k < window.count; ++k) {
    const IntervalModel& model = window.intervals[k];
    const Stage& s = stages_[k];
    NodeStep& step = window.step[k];
    StateVector& next = window.step[k + 1].dx;
    step.du = s.K * step.dx + s.k;
    Eigen::Matrix<double, V + 1, 1> w;
    w << step.dx, step.du, 1.0;
    step.middle_step = s.to_middle * w;
    step.middle_step.tail<U>() = step.du;
    next = 2.0 * step.middle_step.head<S>() - step.dx;
    const VariableVector along = model.hessian * step.middle_step + delta_ * step.middle_step + model.gradient;
    VariableVector costate = stages_[k + 1].P * next;
    costate.head<S>() += stages_[k + 1].q + 0.5 * along.head<S>();
    step.pi = -(s.to_middle_transposed * costate.head<S>()).head<S>();
  }
}

void WindowRiccati::add_curvature() { delta_ = std::clamp(10.0 * delta_, 10.0 * first_delta, 1.0); }

}  // namespace gripline::time_optimal
