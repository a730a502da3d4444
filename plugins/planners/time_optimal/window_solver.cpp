#include "planners/time_optimal/window_solver.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace gripline::time_optimal {
namespace {

/// The constraints of an interval, all "<= 0" in typical sizes.
enum Row : int {
  n_most,
  n_least,
  mid_most,
  mid_least,
  delta_most,
  delta_least,
  rate_most,
  rate_least,
  xi_most,
  xi_least,
  v_least,
  drive_most,
  brake_most,
  front_most,
  front_least,
  rear_most,
  rear_least
};

/// Slip angle of a tyre's largest force [rad]; infinite where its force always grows.
double peak_slip(const MagicFormula& tyre) {
  return tyre.C > 1.0 ? std::tan(0.5 * std::numbers::pi / tyre.C) / tyre.B : std::numeric_limits<double>::infinity();
}

}  // namespace

WindowSolver::WindowSolver(const LapProblem& problem, std::size_t nodes)
    : p_(problem), stages_(nodes + 1), dt_(nodes), dlambda_(nodes), t_(nodes) {
  double width = 0;
  for (std::size_t k = 0; k < p_.size(); ++k) width = std::max(width, p_.n_hi[k] - p_.n_lo[k]);
  const double v = 0.5 * p_.top_speed, grip = p_.tyres.front.D + p_.tyres.rear.D;
  set_car(p_.tyres, {});
  scale_ = {width, 0.5, v, 0.3 * v, std::sqrt(grip / width), p_.car.delta_max, grip, p_.car.ddelta_max};
}

void WindowSolver::set_car(const AxleTyres& tyres, const SpecificResistance& more) {
  p_.tyres = tyres;
  more_ = more;
  slip_front_ = curved() ? std::min(p_.slip_max, peak_slip(tyres.front)) : p_.slip_max;
  slip_rear_ = curved() ? std::min(p_.slip_max, peak_slip(tyres.rear)) : p_.slip_max;
}

template <class T>
void WindowSolver::middle(const std::vector<WindowNode>& lap, std::size_t k, double share, T (&z)[V]) const {
  const WindowNode &here = lap[index(k)], &there = lap[index(k + 1)];
  for (int j = 0; j < V; ++j) {
    const auto i = static_cast<std::size_t>(j);
    double value = j < S ? 0.5 * (here.z[i] + there.z[i]) : here.z[i];
    if (share != 0.0)
      value += share * scale_[i] * (j < S ? 0.5 * (stages_[k].dx[j] + stages_[k + 1].dx[j]) : stages_[k].du[j - S]);
    if constexpr (std::is_same_v<T, double>)
      z[j] = value;
    else
      z[j] = T::variable(value, j);
  }
}

template <class T>
LapRates<T> WindowSolver::rates(std::size_t i, const T (&z)[V]) const {
  LapRates<T> r = lap_rates(p_.car, p_.tyres, p_.drive.coast, p_.places[i], z);
  r.state[lap_vx] -= (more_.rolling + more_.drag * (z[lap_vx] * z[lap_vx])) * r.time;
  return r;
}

template <class T>
T WindowSolver::cost(std::size_t i, const T (&z)[V], const LapRates<T>& r) const {
  const T rate = z[lap_rate] * (1.0 / scale_[lap_rate]);
  return p_.ds[i] * r.time * (1.0 + p_.smoothness * rate * rate);
}

/// AxleSharing of both axles.
template <class T, class Put>
void WindowSolver::share_friction(double grip, const T& a, const LapRates<T>& r, const Put& put) const {
  using std::atan;
  constexpr double from_brake_to_drive = 0.5;  // [m/s2]
  const AxleSharing& own = p_.sharing;
  const double mean = 0.5 * (own.drive_front + own.brake_front), rise = own.drive_front - own.brake_front;
  const T front = mean + (rise / std::numbers::pi) * atan(a * (1.0 / from_brake_to_drive));
  const auto axle = [&](int row, const T& force, const T& share, double load, double D) {
    const T across = force * (1.0 / D), along = share * a * (1.0 / (own.ratio * D)),
            carried = r.load + (grip * load) * a;
    put(row, across * across + along * along - carried * carried);
  };
  axle(front_least, r.front, front, own.load_front, p_.tyres.front.D);
  axle(rear_least, r.rear, 1.0 - front, own.load_rear, p_.tyres.rear.D);
}

/// Those of drive, brakes, slips or the friction circle.
template <class T, class Put>
void WindowSolver::nonlinear_constraints(double grip, const T (&z)[V], const LapRates<T>& r, const Put& put) const {
  const double unit = 1.0 / scale_[lap_a];
  put(drive_most, unit * (z[lap_a] - apply(p_.drive.drive, z[lap_vx])));
  put(brake_most, -unit * (z[lap_a] + apply(p_.drive.brake, z[lap_vx])));
  const auto both_ways = [&](int row, const T& slip, double most) {
    const T relative = slip * (1.0 / most);
    put(row, relative * relative - 1.0);
  };
  if (p_.sharing.ratio > 0) {
    both_ways(front_most, r.slip_front, slip_front_);
    both_ways(rear_most, r.slip_rear, slip_rear_);
    share_friction(grip, z[lap_a], r, put);
    return;
  }
  put(front_most, r.slip_front - slip_front_);
  put(front_least, -1.0 * r.slip_front - slip_front_);
  if (p_.combined > 0) {
    both_ways(rear_most, r.slip_rear, slip_rear_);
    const double most = p_.tyres.front.D + p_.tyres.rear.D;
    const T along = (p_.combined / most) * z[lap_a], across = (r.front + r.rear) * (1.0 / most);
    put(rear_least, along * along + across * across - r.load * r.load);
  } else {
    put(rear_most, r.slip_rear - slip_rear_);
    put(rear_least, -1.0 * r.slip_rear - slip_rear_);
  }
}

/// put(row, value, variable, slope): each depends on one variable in the middle, n_most and n_least on n at the next
/// node instead.
template <class Put>
void WindowSolver::linear_constraints(std::size_t i, const double (&z)[V], double n_next, const Put& put) const {
  const std::size_t j = i + 1 < p_.size() ? i + 1 : 0;
  const double w = scale_[lap_n], lock = p_.car.delta_max / scale_[lap_delta];
  put(n_most, (n_next - p_.n_hi[j]) / w, -1, 1.0);
  put(n_least, (p_.n_lo[j] - n_next) / w, -1, -1.0);
  put(mid_most, (z[lap_n] - p_.mid_hi[i]) / w, lap_n, 1.0);
  put(mid_least, (p_.mid_lo[i] - z[lap_n]) / w, lap_n, -1.0);
  put(delta_most, z[lap_delta] / scale_[lap_delta] - lock, lap_delta, 1.0);
  put(delta_least, -z[lap_delta] / scale_[lap_delta] - lock, lap_delta, -1.0);
  put(rate_most, z[lap_rate] / scale_[lap_rate] - 1.0, lap_rate, 1.0);
  put(rate_least, -z[lap_rate] / scale_[lap_rate] - 1.0, lap_rate, -1.0);
  const double askew = 0.45 * std::numbers::pi;
  put(xi_most, (z[lap_xi] - askew) / scale_[lap_xi], lap_xi, 1.0);
  put(xi_least, (-z[lap_xi] - askew) / scale_[lap_xi], lap_xi, -1.0);
  put(v_least, (0.05 * p_.top_speed - z[lap_vx]) / scale_[lap_vx], lap_vx, -1.0);
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
  using Dual = SecondOrderDual<V>;
  const std::size_t i = index(k);
  WindowNode& node = lap[i];
  Stage& stage = stages_[k];
  Dual z[V];
  middle(lap, k, 0.0, z);
  const LapRates<Dual> r = rates(i, z);
  Dual lagrangian = cost(i, z, r);
  for (int j = 0; j < V; ++j) stage.gradient[j] = lagrangian.g[j] * scale_[static_cast<std::size_t>(j)];

  StateMatrix F;
  InputMatrix G;
  StateVector f;
  for (int j = 0; j < S; ++j) {
    const double step = p_.ds[i] / scale_[static_cast<std::size_t>(j)];
    f[j] = step * r.state[j].v;
    for (int m = 0; m < S; ++m) F(j, m) = step * r.state[j].g[m] * scale_[static_cast<std::size_t>(m)];
    for (int m = S; m < V; ++m) G(j, m - S) = step * r.state[j].g[m] * scale_[static_cast<std::size_t>(m)];
    lagrangian -= (node.pi[static_cast<std::size_t>(j)] * step) * r.state[j];
  }

  double middle_value[V];
  for (int j = 0; j < V; ++j) middle_value[j] = z[j].v;
  linear_constraints(i, middle_value, lap[index(k + 1)].z[lap_n], [&](int row, double value, int by, double slope) {
    stage.c.value[static_cast<std::size_t>(row)] = value;
    if (by >= 0) stage.c.by(row, by) = slope;
  });
  nonlinear_constraints(p_.places[i].grip, z, r, [&](int row, const Dual& c) {
    stage.c.value[static_cast<std::size_t>(row)] = c.v;
    for (int m = 0; m < V; ++m) stage.c.by(row, m) = c.g[m] * scale_[static_cast<std::size_t>(m)];
    if (node.started) lagrangian += node.lambda[static_cast<std::size_t>(row)] * c;
  });
  if (!node.started) start_constraints(node, stage.c);

  for (int a = 0; a < V; ++a)
    for (int b = 0; b <= a; ++b)
      stage.hessian(a, b) = stage.hessian(b, a) =
          lagrangian.h[Dual::entry(a, b)] * scale_[static_cast<std::size_t>(a)] * scale_[static_cast<std::size_t>(b)];
  add_constraints(node, stage);
  eliminate(lap, k, F, G, f);
}

/// (I - F / 2) x+ = (I + F / 2) x + G u - defect.
void WindowSolver::eliminate(const std::vector<WindowNode>& lap, std::size_t k, const StateMatrix& F,
                             const InputMatrix& G, const StateVector& f) {
  Stage& stage = stages_[k];
  const WindowNode &here = lap[index(k)], &there = lap[index(k + 1)];
  StateVector defect;
  for (int j = 0; j < S; ++j) {
    const auto i = static_cast<std::size_t>(j);
    defect[j] = (there.z[i] - here.z[i]) / scale_[i] - f[j];
  }
  const StateMatrix implicit = StateMatrix::Identity() - 0.5 * F;
  stage.inverse = implicit.partialPivLu().inverse();
  stage.A.noalias() = stage.inverse * (StateMatrix::Identity() + 0.5 * F);
  stage.B.noalias() = stage.inverse * G;
  stage.b.noalias() = -stage.inverse * defect;
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
  double sum = 0, wrong = 0, barrier = 0;
  for (std::size_t k = 0; k < count_; ++k) {
    const std::size_t i = index(k);
    double z[V];
    middle(lap, k, share, z);
    const LapRates<double> r = rates(i, z);
    sum += cost(i, z, r);
    const WindowNode &here = lap[i], &there = lap[index(k + 1)];
    for (int j = 0; j < S; ++j) {
      const auto m = static_cast<std::size_t>(j);
      const double rise = (there.z[m] - here.z[m]) / scale_[m] + share * (stages_[k + 1].dx[j] - stages_[k].dx[j]);
      wrong += state_penalty_[m] * std::abs(rise - p_.ds[i] / scale_[m] * r.state[j]);
    }
    const auto add = [&](int row, double value) {
      const auto at = static_cast<std::size_t>(row);
      double t = here.t[at];
      if (share != 0.0) {
        t = kept_positive(t, share * dt_[k][at]);
        // A slack is what its constraint leaves, where that is not much less than the step says.
        if (curved() && -value > 0.1 * t) t = -value;
      }
      if (share != 0.0) t_[k][at] = t;
      barrier += std::log(t);
      wrong += row_penalty_[at] * std::abs(value + t);
    };
    const double n_next = there.z[lap_n] + share * scale_[lap_n] * stages_[k + 1].dx[lap_n];
    linear_constraints(i, z, n_next, [&](int row, double value, int, double) { add(row, value); });
    nonlinear_constraints(p_.places[i].grip, z, r, add);
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
  if (!curved()) {
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
