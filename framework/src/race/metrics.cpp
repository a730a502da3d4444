#include "race/metrics.hpp"

#include <algorithm>
#include <cmath>

namespace gripline {

static constexpr double hilly_from = 0.03;  // grade

std::string_view status_name(Status status) {
  constexpr std::string_view names[] = {"finished", "crashed", "stuck", "timeout", "plugin_error", "error"};
  return names[static_cast<std::size_t>(status)];
}

double distance_to_line(std::span<const LinePoint> line, double x, double y) {
  double nearest = INFINITY;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const LinePoint& a = line[i];
    const LinePoint& b = line[i + 1 < line.size() ? i + 1 : 0];
    const double ex = b.x - a.x, ey = b.y - a.y;
    const double length2 = ex * ex + ey * ey;
    const double along = length2 > 0 ? std::clamp(((x - a.x) * ex + (y - a.y) * ey) / length2, 0.0, 1.0) : 0.0;
    const double dx = x - a.x - along * ex, dy = y - a.y - along * ey;
    nearest = std::min(nearest, dx * dx + dy * dy);
  }
  return std::sqrt(nearest);
}

Metrics::Metrics(const World& world, const StackSpec& stack, std::uint64_t seed)
    : world_(world), factor_of_step_(world.truth().factor()), car_weight_(world.spec().car.car.m * gravity) {
  summary_.stack = stack.name;
  summary_.seed = seed;
  summary_.needs_truth = stack.needs_truth();
}

double Metrics::mu_true() const {
  const Truth& truth = world_.truth();
  return total_mu({.mu_front = truth.mu(Axle::front), .mu_rear = truth.mu(Axle::rear)}, world_.spec().car.car);
}

/// A car that stands visits no slip: that of its front axle would be the angle at which the wheels are turned, and that
/// of a car that creeps sideways any angle.
void Metrics::visit_slips() {
  if (std::hypot(world_.state().vx, world_.state().vy) < world_.spec().car.car.v_min) return;
  visit_slip(Axle::front);
  visit_slip(Axle::rear);
}

/// Largest true force over the slips visited so far. Evaluated only when the slip exceeds the largest one before, and
/// at points in between, because one step may pass over the peak.
void Metrics::visit_slip(Axle axle) {
  const auto i = static_cast<std::size_t>(axle);
  const double seen = largest_slip_[i];
  const double slip = std::abs(world_.slip(axle));
  if (!(slip > seen)) return;
  largest_slip_[i] = slip;
  constexpr double spacing = 0.005;  // [rad]
  const int count = static_cast<int>(std::clamp(std::ceil((slip - seen) / spacing), 1.0, 400.0));
  for (int k = 1; k <= count; ++k) {
    const double force = world_.truth().tyre_force(axle, seen + (slip - seen) * k / count) / world_.truth().factor();
    largest_force_[i] = std::max(largest_force_[i], force);
  }
}

void Metrics::lap(double ended) {
  summary_.laps.push_back(ended - lap_began_);
  summary_.lap_mean_factors.push_back(factor_.mean());
  lap_began_ = ended;
  factor_ = {};
}

void Metrics::add_friction_error(const Belief& belief) {
  const double driven = world_.covered() / world_.track().length();
  if (!trusted_since_) trusted_since_ = driven;
  const double estimated = total_mu(belief, world_.spec().car.car);
  const double error = estimated - mu_true();
  mu_square_.add(error * error);
  bias_.add(error);
  if (driven < *trusted_since_ + 2) return;
  const double visited = world_.truth().factor() * (largest_force_[0] + largest_force_[1]) / car_weight_;
  visited_square_.add((estimated - visited) * (estimated - visited));
}

void Metrics::start(bool solved) {
  if (!solved) ++summary_.solver_failures;
}

void Metrics::step() {
  ++summary_.steps;
  summary_.simulated_s = world_.time();
  factor_.add(factor_of_step_);
  factor_of_step_ = world_.truth().factor();
  if (world_.lap_ended()) lap(*world_.lap_ended());
  visit_slips();
  outside_.add(world_);
}

void Metrics::decision(const StackBelief& belief, std::span<const LinePoint> line, bool solved, double plan_latency) {
  summary_.plan_latency_s = std::max(summary_.plan_latency_s, plan_latency);
  if (!solved) ++summary_.solver_failures;
  if (!line.empty()) {
    const double distance = distance_to_line(line, world_.state().x, world_.state().y);
    deviation_.add(distance);
    if (std::abs(std::tan(world_.place().grade)) > hilly_from) hilly_deviation_.add(distance);
  }
  if (!belief.mu.trusted) return;
  if (!outside_after_adapt_) outside_after_adapt_.emplace();
  outside_after_adapt_->add(world_);
  add_friction_error(belief.mu);
}

RunSummary Metrics::summary(Status status, std::string message) const {
  RunSummary out = summary_;
  out.status = status;
  out.message = std::move(message);
  if (out.many_failed_solves()) {
    if (!out.message.empty()) out.message += "; ";
    out.message += std::to_string(out.solver_failures) + " of " + std::to_string(out.solves()) + " solves failed";
  }
  if (deviation_.count > 0) out.mean_deviation_m = deviation_.mean();
  if (hilly_deviation_.count > 0) out.hilly_deviation_m = hilly_deviation_.mean();
  const auto time = [dt = world_.spec().dt](std::int64_t steps) { return static_cast<double>(steps) * dt; };
  out.violation_s = time(outside_.centre);
  out.violation_body_s = time(outside_.body);
  if (outside_after_adapt_) {
    out.violation_after_adapt_s = time(outside_after_adapt_->centre);
    out.violation_body_after_adapt_s = time(outside_after_adapt_->body);
  }
  if (mu_square_.count > 0) {
    out.mu_rmse = std::sqrt(mu_square_.mean());
    out.mu_bias = bias_.mean();
  }
  if (visited_square_.count > 0) out.mu_visited_rmse = std::sqrt(visited_square_.mean());
  return out;
}

}  // namespace gripline
