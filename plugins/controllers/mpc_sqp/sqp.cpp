#include "controllers/mpc_sqp/sqp.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gripline::mpc {
namespace {

constexpr std::size_t heading = 2;  // index of yaw in a row of x
constexpr int steering = 6;         // index of delta in a row of x
constexpr double decrease = 0.1;    // share of the promised fall of the merit that a step must bring
constexpr int halvings = 7;         // of a step before it is given up
// Damping after a shortened step, its growth, and its bounds, all relative to the curvature that the last step met.
constexpr double damping_first = 0.1, damping_change = 10, damping_most = 1e4;

double throttle_range(const Car& car) { return car.d_max - car.d_min; }
double rate_range(const Car& car) { return 2 * car.ddelta_max; }

}  // namespace

Sqp::Sqp(int horizon, int states, const SqpOptions& options)
    : horizon_(horizon),
      states_(states),
      options_(options),
      program_(horizon, states + 1),
      solver_(horizon, states + 1),
      curvature_(horizon, states),
      multipliers_(static_cast<std::size_t>(horizon + 1) * static_cast<std::size_t>(program_.links.n)),
      prices_(static_cast<std::size_t>(states)) {
  const auto n = static_cast<std::size_t>(states), stages = static_cast<std::size_t>(horizon);
  for (Iterate* one : {&now_, &trial_}) {
    one->x.resize((stages + 1) * n);
    one->u.resize(stages * 2);
    one->x_next.resize(stages * n);
    one->a.resize(stages * n * n);
    one->b.resize(stages * n * 2);
  }
  program_.links.bounded_state = steering;
}

/// Steers to a reference ahead and accelerates towards its speed: roughly what any driver would do.
Input Sqp::pursue(const Problem& problem, const double* x, int k) const {
  const Car& car = problem.car();
  const double wheelbase = car.lf + car.lr;
  const auto distance = [&](int j) { return std::hypot(problem.stage(j).x - x[0], problem.stage(j).y - x[1]); };
  int target = k + 1;
  while (target < horizon_ && distance(target) < 3 * wheelbase + 0.1 * std::abs(x[3])) ++target;
  const double away = std::max(distance(target), wheelbase);
  const double bearing = std::atan2(problem.stage(target).y - x[1], problem.stage(target).x - x[0]) - x[2];
  const double delta = std::clamp(std::atan(2 * wheelbase * std::sin(bearing) / away), -car.delta_max, car.delta_max);
  return {std::clamp(5 * (problem.stage(k + 1).v - x[3]) / car.v_ref, car.d_min, car.d_max),
          std::clamp((delta - x[steering]) / problem.dt(), -car.ddelta_max, car.ddelta_max)};
}

void Sqp::guess(const Problem& problem, Prediction& model) {
  const auto n = static_cast<std::size_t>(states_);
  std::copy(problem.start().begin(), problem.start().end(), now_.x.begin());
  for (std::size_t k = 0; k < static_cast<std::size_t>(horizon_); ++k) {
    const Input u = pursue(problem, now_.x.data() + k * n, static_cast<int>(k));
    now_.u[2 * k] = u.d;
    now_.u[2 * k + 1] = u.ddelta;
    model.step(1, std::span(now_.x).subspan(k * n, n), std::span(now_.u).subspan(2 * k, 2),
               problem.places().subspan(k, 1), std::span(now_.x).subspan((k + 1) * n, n), {}, {});
  }
  curvature_.forget();
  solver_.forget_guess();
}

void Sqp::shift() {
  const auto n = static_cast<std::size_t>(states_);
  std::copy(now_.x.begin() + static_cast<std::ptrdiff_t>(n), now_.x.end(), now_.x.begin());
  std::copy(now_.u.begin() + 2, now_.u.end(), now_.u.begin());
  now_.u.back() = 0;
  if (horizon_ > 1) {
    // The last state goes on as it went, the steering held.
    double* last = now_.x.data() + static_cast<std::size_t>(horizon_) * n;
    for (std::size_t i = 0; i < n; ++i) last[i] += *(last - n + i) - *(last - 2 * n + i);
    last[steering] = *(last - n + steering);
  }
  curvature_.shift();
  for (int k = 0; k < horizon_; ++k) {
    std::copy_n(solver_.side(k + 1), ocp::row_count, solver_.side(k));
    std::copy_n(solver_.row_multiplier(k + 1), ocp::row_count, solver_.row_multiplier(k));
  }
  // Stage N had no inputs to take over.
  for (const int row : {ocp::row_input0, ocp::row_input1}) {
    solver_.side(horizon_ - 1)[row] = horizon_ > 1 ? solver_.side(horizon_ - 2)[row] : ocp::Side::free;
    solver_.row_multiplier(horizon_ - 1)[row] = 0;
  }
}

/// Predictions, Jacobians and cost of an iterate; false if anything of it is not finite.
bool Sqp::linearise(const Problem& problem, Prediction& model, Iterate& at) {
  const std::size_t n = static_cast<std::size_t>(states_), stages = static_cast<std::size_t>(horizon_);
  model.step(stages, std::span(at.x).first(stages * n), at.u, problem.places(), at.x_next, at.a, at.b);
  at.cost = problem.cost(at.x, at.u);
  double total = at.cost;
  for (const double v : at.x_next) total += v;
  for (const double v : at.a) total += v;
  for (const double v : at.b) total += v;
  return std::isfinite(total);
}

void Sqp::set_hessian(const Problem& problem) {
  const ProblemParams& p = problem.params();
  const Car& car = problem.car();
  ocp::Links& links = program_.links;
  const int n = links.n, width = links.width, before = states_;
  for (int k = 0; k <= horizon_; ++k) {
    double* h = links.hessian_x(k);
    std::fill_n(h, n * n, 0.0);
    if (k > 0) {
      const Stage& s = problem.stage(k);
      h[0] = 2 * s.q_xx;
      h[1] = h[n] = 2 * s.q_xy;
      h[n + 1] = 2 * s.q_yy;
      h[2 * n + 2] = 2 * s.q_yaw;
      h[3 * n + 3] = 2 * s.q_v;
      links.row(k)[0] = s.normal_x;
      links.row(k)[1] = s.normal_y;
    }
    if (k == horizon_) break;
    h[before * n + before] = 2 * p.r_d;
    double* hu = links.hessian_u(k);
    std::fill_n(hu, 2 * width, 0.0);
    hu[0] = 2 * (p.r_d + p.regularization) + damping_ / square(throttle_range(car));
    hu[4 + before] = -2 * p.r_d;
    hu[width + 1] = 2 * problem.weight_ddelta() + damping_ / square(rate_range(car));
  }
  curvature_.add_to(links);
}

/// Gradients, bounds and dynamics of the program in the steps from now_.
void Sqp::set_step_program(const Problem& problem) {
  const ProblemParams& p = problem.params();
  const Car& car = problem.car();
  const auto n = static_cast<std::size_t>(states_);
  ocp::Links& links = program_.links;
  program_.soft_quadratic = p.slack;
  program_.soft_linear = p.slack_linear;
  double throttle = problem.throttle_before();
  for (int k = 0; k <= horizon_; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const double* x = now_.x.data() + at * n;
    double *g = links.gradient(k), *lower = program_.lower(k), *upper = program_.upper(k);
    if (k > 0) {
      const Stage& s = problem.stage(k);
      const double ex = x[0] - s.x, ey = x[1] - s.y, edge = s.normal_x * x[0] + s.normal_y * x[1];
      g[4] = 2 * (s.q_xx * ex + s.q_xy * ey);
      g[5] = 2 * (s.q_xy * ex + s.q_yy * ey);
      g[6] = 2 * s.q_yaw * (x[2] - s.yaw);
      g[7] = 2 * s.q_v * (x[3] - s.v);
      lower[ocp::row_state] = -s.delta_max - x[steering];
      upper[ocp::row_state] = s.delta_max - x[steering];
      lower[ocp::row_soft] = s.edge_lower - edge;
      upper[ocp::row_soft] = s.edge_upper - edge;
    }
    if (k == horizon_) break;
    const double d = now_.u[2 * at], ddelta = now_.u[2 * at + 1];
    g[0] = 2 * (p.r_d * (d - throttle) + p.regularization * d);
    g[1] = 2 * problem.weight_ddelta() * ddelta;
    g[4 + n] = -2 * p.r_d * (d - throttle);
    throttle = d;
    lower[ocp::row_input0] = car.d_min - d;
    upper[ocp::row_input0] = car.d_max - d;
    lower[ocp::row_input1] = -car.ddelta_max - ddelta;
    upper[ocp::row_input1] = car.ddelta_max - ddelta;
    links.set_dynamics(k, now_.a.data() + at * n * n, now_.b.data() + at * n * 2, states_);
    links.link(k)[n * static_cast<std::size_t>(links.width)] = 1;  // the throttle remembered
    for (std::size_t i = 0; i < n; ++i) links.offset(k)[i] = now_.x_next[at * n + i] - x[n + i];
  }
}

/// Without the curvature that was learned, should that make the program not convex.
bool Sqp::solve_step_program(const Problem& problem, SqpReport& report) {
  const auto solve = [&] {
    set_hessian(problem);
    const ocp::QpReport qp = solver_.solve(program_, nullptr, options_.qp);
    report.active_set_iterations += qp.active_set_iterations;
    report.interior_iterations += qp.interior_iterations;
    return qp.solved;
  };
  set_step_program(problem);
  if (solve()) return true;
  if (curvature_.empty()) return false;
  curvature_.forget();
  return solve();
}

/// The largest step of an input as a share of its range.
double Sqp::step_size(const Problem& problem) const {
  const Car& car = problem.car();
  double largest = 0;
  for (int k = 0; k < horizon_; ++k) {
    const double* u = solver_.input(k);
    largest = std::max({largest, std::abs(u[0]) / throttle_range(car), std::abs(u[1]) / rate_range(car)});
  }
  return largest;
}

double Sqp::squared_step(const Problem& problem) const {
  const Car& car = problem.car();
  double total = 0;
  for (int k = 0; k < horizon_; ++k) {
    const double* u = solver_.input(k);
    total += square(u[0] / throttle_range(car)) + square(u[1] / rate_range(car));
  }
  return total;
}

void Sqp::take_step(double length, Iterate& to) const {
  const auto n = static_cast<std::size_t>(states_);
  for (int k = 0; k <= horizon_; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const double *dx = solver_.state(k), *du = solver_.input(k);
    for (std::size_t i = 0; i < n; ++i) to.x[at * n + i] = now_.x[at * n + i] + length * dx[i];
    if (k == horizon_) return;
    to.u[2 * at] = now_.u[2 * at] + length * du[0];
    to.u[2 * at + 1] = now_.u[2 * at + 1] + length * du[1];
  }
}

/// The merit is exact, and the program's solution a descent of it, when a defect costs more than its multiplier.
void Sqp::price_defects() {
  solver_.dynamics_multipliers(program_, multipliers_.data());
  const int n = program_.links.n;
  for (int i = 0; i < states_; ++i) {
    double most = 0;
    for (int k = 1; k <= horizon_; ++k) most = std::max(most, std::abs(multipliers_.data()[k * n + i]));
    double& price = prices_[static_cast<std::size_t>(i)];
    price = std::max(0.5 * (price + 1.5 * most), 1.5 * most);
  }
}

double Sqp::defect_cost(const Iterate& at) const {
  const auto n = static_cast<std::size_t>(states_);
  double total = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(horizon_); ++k) {
    for (std::size_t i = 0; i < n; ++i) total += prices_[i] * std::abs(at.x_next[k * n + i] - at.x[(k + 1) * n + i]);
  }
  return total;
}

/// The length of the step to trial_, which is then linearised; 0 if none is short enough to improve the merit. The cost is
/// convex and the linearised defects vanish, so a step of length a promises a times what the full one does. With learned curvature the
/// promise can be a small rise, and a tenth of it is granted: near the solution a strict descent of this merit turns good
/// steps away (measured: the first input's error grows from 1.5e-4 to 3e-3 of its range).
double Sqp::search(const Problem& problem, Prediction& model, SqpReport& report) {
  price_defects();
  take_step(1, trial_);
  const double merit = now_.cost + defect_cost(now_);
  const double rounding = 1e-10 * std::abs(merit);
  promised_ = merit - problem.cost(trial_.x, trial_.u);
  double length = 1;
  for (int halving = 0; halving < halvings; ++halving, length *= 0.5) {
    take_step(length, trial_);
    ++report.predictions;
    if (!linearise(problem, model, trial_)) continue;
    if (trial_.cost + defect_cost(trial_) <= merit - decrease * length * promised_ + rounding) return length;
  }
  return 0;
}

/// Puts the problem's start into the iterate; a heading that was wrapped since is unwrapped for all of it.
void Sqp::meet(const Problem& problem) {
  const auto n = static_cast<std::size_t>(states_);
  const double turn = 2 * std::numbers::pi;
  const double jump = turn * std::round((problem.start()[heading] - now_.x[heading]) / turn);
  for (std::size_t i = heading; std::isfinite(jump) && i < now_.x.size(); i += n) now_.x[i] += jump;
  std::copy(problem.start().begin(), problem.start().end(), now_.x.begin());
}

SqpReport Sqp::solve(const Problem& problem, Prediction& model) {
  SqpReport report;
  meet(problem);
  std::fill(prices_.begin(), prices_.end(), 0.0);
  damping_ = 0;
  double share = 0;  // damping relative to the curvature met
  ++report.predictions;
  if (!linearise(problem, model, now_)) return report;
  const auto end = [&](SqpStatus status) {
    report.status = status;
    report.cost = now_.cost;
    return report;
  };
  while (report.iterations < options_.iterations) {
    ++report.iterations;
    if (!solve_step_program(problem, report)) return end(SqpStatus::no_step);
    if (step_size(problem) <= options_.tolerance) {
      take_step(1, now_);
      now_.cost = problem.cost(now_.x, now_.u);
      return end(SqpStatus::converged);
    }
    const double length = search(problem, model, report);
    if (length == 0 && curvature_.empty() && share >= damping_most) return end(SqpStatus::no_descent);
    share = length == 1 ? share / damping_change : std::max(damping_first, share * damping_change);
    if (share < 0.01 * damping_first) share = 0;
    damping_ = share * std::abs(promised_) / std::max(squared_step(problem), 1e-12);
    if (length == 0) {
      curvature_.forget();
      continue;
    }
    curvature_.learn(now_, trial_, multipliers_.data(), program_.links.n);
    std::swap(now_, trial_);
  }
  return end(SqpStatus::iteration_limit);
}

}  // namespace gripline::mpc
