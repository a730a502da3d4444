#include "controllers/mpc_sqp/sqp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace gripline::mpc_sqp {
namespace {

// Of the learned curvature, tried in this order until the quadratic program is convex and its step can be trusted.
constexpr double curvature_shares[] = {1, 0.5, 0.25, 0.1, 0};
// Learned curvature may ask for twice the step that was taken before, and always for this share of an input's range. A
// longer one says that the curvature learned is too small somewhere: it is cut to 1/16 and less in the line search.
constexpr double least_trusted_step = 0.05;
// How fast and how slowly steps are thought to fall, and the share of the tolerance of steps that the first inputs may
// be off: they are driven, the others only planned.
constexpr double fastest_rate = 0.2, slowest_rate = 0.9, first_step_share = 0.05, rounding = 1e-9;

}  // namespace

Sqp::Sqp(int N, int nx, const SqpOptions& options)
    : N_(N),
      nx_(nx),
      options_(options),
      qp_(N, nx + 1),
      qp_solver_(N, nx + 1),
      sr1_(N, nx),
      pi_(static_cast<std::size_t>(N + 1) * static_cast<std::size_t>(qp_.dims.ldx)),
      merit_(N, nx),
      now_(N, nx),
      trial_(N, nx),
      steering_low_(static_cast<std::size_t>(N + 1)),
      steering_high_(static_cast<std::size_t>(N + 1)) {
  qp_.idxbx = delta_index;
}

/// Steers to a reference ahead and accelerates towards its speed.
Input Sqp::pursuit_input(const mpc::Ocp& ocp, const double* x, int k) const {
  const Car& car = ocp.car();
  const double wheelbase = car.lf + car.lr;
  const auto distance = [&](int j) { return std::hypot(ocp.stage(j).x - x[0], ocp.stage(j).y - x[1]); };
  int target = k + 1;
  while (target < N_ && distance(target) < 3 * wheelbase + 0.1 * std::abs(x[3])) ++target;
  const double away = std::max(distance(target), wheelbase);
  const double bearing = std::atan2(ocp.stage(target).y - x[1], ocp.stage(target).x - x[0]) - x[yaw_index];
  const double delta = std::clamp(std::atan(2 * wheelbase * std::sin(bearing) / away), -car.delta_max, car.delta_max);
  return {std::clamp(5 * (ocp.stage(k + 1).v - x[3]) / car.v_ref, car.d_min, car.d_max),
          std::clamp((delta - x[delta_index]) / ocp.dt(), -car.ddelta_max, car.ddelta_max)};
}

void Sqp::initialize(const mpc::Ocp& ocp, Prediction& model) {
  const auto n = static_cast<std::size_t>(nx_);
  std::copy(ocp.start().begin(), ocp.start().end(), now_.x.begin());
  for (std::size_t k = 0; k < static_cast<std::size_t>(N_); ++k) {
    const Input u = pursuit_input(ocp, now_.x.data() + k * n, static_cast<int>(k));
    now_.u[2 * k] = u.d;
    now_.u[2 * k + 1] = u.ddelta;
    model.step(1, std::span(now_.x).subspan(k * n, n), std::span(now_.u).subspan(2 * k, 2), ocp.places().subspan(k, 1),
               std::span(now_.x).subspan((k + 1) * n, n), {}, {});
  }
  sr1_.reset();
  qp_solver_.reset();
  // What trials by value need is taken now.
  trial_ = now_;
  predict(ocp, model, trial_);
}

void Sqp::shift() {
  const auto n = static_cast<std::size_t>(nx_);
  std::copy(now_.x.begin() + static_cast<std::ptrdiff_t>(n), now_.x.end(), now_.x.begin());
  std::copy(now_.u.begin() + 2, now_.u.end(), now_.u.begin());
  now_.u.back() = 0;
  if (N_ > 1) {
    // The last state goes on as it went, the steering held.
    double* last = now_.x.data() + static_cast<std::size_t>(N_) * n;
    for (std::size_t i = 0; i < n; ++i) last[i] += *(last - n + i) - *(last - 2 * n + i);
    last[delta_index] = *(last - n + delta_index);
  }
  sr1_.shift();
  for (int k = 0; k < N_; ++k) {
    std::copy_n(qp_solver_.status(k + 1), con_count, qp_solver_.status(k));
    std::copy_n(qp_solver_.lam(k + 1), con_count, qp_solver_.lam(k));
  }
  // Stage N had no inputs to take over.
  for (const int con : {con_u0, con_u1}) {
    qp_solver_.status(N_ - 1)[con] = N_ > 1 ? qp_solver_.status(N_ - 2)[con] : BoundStatus::inactive;
    qp_solver_.lam(N_ - 1)[con] = 0;
  }
}

/// The program in the steps from now_, with as much of the learned curvature as leaves it convex and its step trusted.
/// What does not fit now is kept: with another active set, or a stage later, it may. With curvature the active set
/// decides alone: where it does not settle the program is hardly convex, and an interior-point method would be long.
bool Sqp::solve_qp(const mpc::Ocp& ocp, SqpStatistics& statistics) {
  const auto solve = [&](double share) {
    set_cost_hessian(ocp, levenberg_marquardt_.damping(), qp_);
    if (share > 0) sr1_.add_to(qp_, share);
    OcpQpSolverOptions options = options_.qp_solver;
    if (share > 0) options.ip_iter_max = 0;
    const OcpQpSolverStatistics qp = qp_solver_.solve(qp_, nullptr, options);
    statistics.qp_active_set_iter += qp.active_set_iter;
    statistics.qp_ip_iter += qp.ip_iter;
    if (!qp.solved) return false;
    statistics.step_norm = step_norm(ocp, N_);
    return share == 0 || statistics.step_norm <= trusted_step_;
  };
  set_cost_gradient(ocp, now_, qp_);
  set_constraints(ocp, now_, qp_);
  statistics.res_eq = set_dynamics(now_, nx_, qp_);
  if (sr1_.empty()) return solve(0);
  return std::any_of(std::begin(curvature_shares), std::end(curvature_shares), solve);
}

/// The largest step of an input in the first `stages` stages, as a share of its range.
double Sqp::step_norm(const mpc::Ocp& ocp, int stages) const {
  const Car& car = ocp.car();
  double largest = 0;
  for (int k = 0; k < stages; ++k) {
    const double* u = qp_solver_.u(k);
    largest = std::max({largest, std::abs(u[0]) / d_range(car), std::abs(u[1]) / ddelta_range(car)});
  }
  return largest;
}

/// Whether no input moves any more, and the first one will not: what it has still to go is estimated by a geometric
/// series of steps, at the rate at which the last two shrank.
bool Sqp::converged(const mpc::Ocp& ocp, const SqpStatistics& statistics) const {
  if (statistics.step_norm > options_.tol_step) return false;
  const double last = std::max(last_step_, std::numeric_limits<double>::min());  // of an iterate that is optimal: 0
  const double rate = std::clamp(statistics.step_norm / last, fastest_rate, slowest_rate);
  return step_norm(ocp, 1) * rate / (1 - rate) <= first_step_share * options_.tol_step + rounding;
}

double Sqp::squared_step(const mpc::Ocp& ocp) const {
  const Car& car = ocp.car();
  double total = 0;
  for (int k = 0; k < N_; ++k) {
    const double* u = qp_solver_.u(k);
    total += square(u[0] / d_range(car)) + square(u[1] / ddelta_range(car));
  }
  return total;
}

void Sqp::take_step(double alpha, NlpIterate& to) const {
  const auto n = static_cast<std::size_t>(nx_);
  for (int k = 0; k <= N_; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const double *dx = qp_solver_.x(k), *du = qp_solver_.u(k);
    for (std::size_t i = 0; i < n; ++i) to.x[at * n + i] = now_.x[at * n + i] + alpha * dx[i];
    if (k == N_) return;
    to.u[2 * at] = now_.u[2 * at] + alpha * du[0];
    to.u[2 * at + 1] = now_.u[2 * at + 1] + alpha * du[1];
  }
}

/// The length of the step to trial_, which is then linearised; 0 if none is short enough to improve the merit. With
/// learned curvature the predicted change can be a small rise, of which a tenth is accepted: to require descent near
/// the solution rejects good steps (measured: the first input's error grows from 1.5e-4 to 3e-3 of its range).
double Sqp::line_search(const mpc::Ocp& ocp, Prediction& model, SqpStatistics& statistics) {
  qp_solver_.get_pi(qp_, pi_.data());
  merit_.update_weights(pi_.data(), qp_.dims.ldx);
  take_step(1, trial_);
  const double merit = merit_(now_);
  const double merit_rounding = 1e-10 * std::abs(merit);
  predicted_decrease_ = merit - ocp.cost(trial_.x, trial_.u);
  double alpha = 1;
  for (int backtrack = 0; backtrack < max_backtracks; ++backtrack, alpha *= 0.5) {
    take_step(alpha, trial_);
    ++statistics.predictions;
    // Most full steps are taken, so that their trial brings the Jacobians along; most shortened ones are not.
    const bool full = backtrack == 0;
    if (!(full ? linearise(ocp, model, trial_) : predict(ocp, model, trial_))) continue;
    if (merit_(trial_) > merit - sufficient_decrease * alpha * predicted_decrease_ + merit_rounding) continue;
    if (full || linearise(ocp, model, trial_)) return alpha;
  }
  return 0;
}

/// Puts the problem's start into the iterate; a heading that was wrapped since is unwrapped for all of it.
void Sqp::set_x0(const mpc::Ocp& ocp) {
  const auto n = static_cast<std::size_t>(nx_);
  const double turn = 2 * std::numbers::pi;
  const double jump = turn * std::round((ocp.start()[yaw_index] - now_.x[yaw_index]) / turn);
  for (std::size_t i = yaw_index; std::isfinite(jump) && i < now_.x.size(); i += n) now_.x[i] += jump;
  std::copy(ocp.start().begin(), ocp.start().end(), now_.x.begin());
}

/// Steering of the iterate within bounds that have moved since it was found, at its rate: backwards the angles from
/// which later bounds can be reached, then forwards the nearest of these. Steps from an iterate outside raise the cost,
/// which is all that the merit function sees of bounds: none would be taken.
void Sqp::clip_steering(const mpc::Ocp& ocp) {
  constexpr double negligible = 1e-9;  // [rad]
  const auto delta = [&](int k) -> double& { return now_.x[static_cast<std::size_t>(k * nx_) + delta_index]; };
  const auto at = [](std::vector<double>& of, int k) -> double& { return of[static_cast<std::size_t>(k)]; };
  const double reach = ocp.dt() * ocp.car().ddelta_max;
  bool inside = true;
  for (int k = N_; k >= 1; --k) {
    double low = ocp.stage(k).delta_min, high = ocp.stage(k).delta_max;
    inside &= delta(k) >= low - negligible && delta(k) <= high + negligible;
    if (k < N_) {
      low = std::min(std::max(low, at(steering_low_, k + 1) - reach), high);
      high = std::max(std::min(high, at(steering_high_, k + 1) + reach), low);
    }
    at(steering_low_, k) = low;
    at(steering_high_, k) = high;
  }
  if (inside) return;
  for (int k = 1; k <= N_; ++k) {
    const double before = delta(k - 1), bounded = std::clamp(delta(k), at(steering_low_, k), at(steering_high_, k));
    delta(k) = std::clamp(bounded, before - reach, before + reach);
    now_.u[static_cast<std::size_t>(2 * k - 1)] = (delta(k) - before) / ocp.dt();
  }
}

SqpStatistics Sqp::solve(const mpc::Ocp& ocp, Prediction& model) {
  SqpStatistics statistics;
  set_x0(ocp);
  clip_steering(ocp);
  merit_.reset();
  trusted_step_ = std::numeric_limits<double>::infinity();
  last_step_ = 0;
  levenberg_marquardt_.reset();
  ++statistics.predictions;
  if (!linearise(ocp, model, now_)) return statistics;
  const auto end = [&](SqpStatus status) {
    statistics.status = status;
    statistics.cost = now_.cost;
    return statistics;
  };
  while (statistics.sqp_iter < options_.max_iter) {
    ++statistics.sqp_iter;
    if (!solve_qp(ocp, statistics)) return end(SqpStatus::qp_failure);
    if (converged(ocp, statistics)) {
      take_step(1, now_);
      now_.cost = ocp.cost(now_.x, now_.u);
      return end(SqpStatus::converged);
    }
    const double alpha = line_search(ocp, model, statistics);
    if (alpha == 0 && sr1_.empty() && levenberg_marquardt_.at_largest()) return end(SqpStatus::min_step);
    levenberg_marquardt_.update(alpha, predicted_decrease_, squared_step(ocp));
    last_step_ = alpha * statistics.step_norm;
    trusted_step_ = std::max(least_trusted_step, 2 * last_step_);
    if (alpha == 0) {
      sr1_.reset();
      continue;
    }
    sr1_.update(now_, trial_, pi_.data(), qp_.dims.ldx);
    std::swap(now_, trial_);
  }
  return end(SqpStatus::max_iter);
}

}  // namespace gripline::mpc_sqp
