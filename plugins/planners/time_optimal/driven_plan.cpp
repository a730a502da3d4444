#include "planners/time_optimal/driven_plan.hpp"

#include <algorithm>
#include <cmath>

#include "common/reference_step.hpp"

namespace gripline::time_optimal {

double share_of_way_in(double dt, double share) {
  const double left = 1.0 - share;
  return share * ((1.0 - std::pow(left, dt / reference_step)) / (1.0 - left));  // exactly `share` in 20 ms
}

DrivenPlan::DrivenPlan(const LapSetup& setup, double mu)
    : setup_(&setup), mu_(setup.nodes().s.size(), mu), v_(mu_.size()) {}

LapPlan::Node DrivenPlan::node_of(const std::vector<WindowNode>& lap, std::size_t i) const {
  return plan_node(*setup_, i, lap[setup_->before(i)].z, lap[i].z, lap[setup_->after(i)].z);
}

/// As node_of(), where there is no node before it.
LapPlan::Node DrivenPlan::first_node_of(const std::vector<WindowNode>& lap, std::size_t i) const {
  const auto &z = lap[i].z, &q = lap[setup_->after(i)].z;
  const double slope = (q[lap_n] - z[lap_n]) / setup_->nodes().ds[i];
  return {z[lap_n], slope, std::hypot(z[lap_vx], z[lap_vy]), std::atan2(z[lap_vy], z[lap_vx]), 0.0};
}

LapPlan DrivenPlan::whole(const std::vector<WindowNode>& lap) {
  LapPlan plan;
  for (std::size_t i = 0; i < lap.size(); ++i) plan.nodes.push_back(node_of(lap, i));
  set_curvatures(*setup_, 0, lap.size(), plan);
  for (std::size_t i = 0; i < lap.size(); ++i) v_[i] = plan.nodes[i].v;
  for (std::size_t i = 0; i < lap.size(); ++i) plan.time += setup_->nodes().ds[i] / plan.nodes[i].v;
  return plan;
}

void DrivenPlan::follow(const LapWindow& window, const std::vector<WindowNode>& lap, std::size_t from, double share,
                        double mu, LapPlan& plan) {
  const auto between = [share](double a, double b) { return a + share * (b - a); };
  for (std::size_t k = from; k < window.near_count(); ++k) {
    const std::size_t i = window.node(k);
    LapPlan::Node& p = plan.nodes[i];
    const LapPlan::Node q = k > 0 ? node_of(lap, i) : first_node_of(lap, i);
    p = {between(p.n, q.n), between(p.slope, q.slope), p.v, between(p.beta, q.beta), p.kappa};
    v_[i] = between(v_[i], q.v);
    mu_[i] = between(mu_[i], mu);
  }
  // Before a plan that begins at the car there is another one.
  const std::size_t first = from == 0 ? 1 : 0;
  set_curvatures(*setup_, window.node(first), window.near_count() + 1 - first, plan);
  if (from == 0) plan.nodes[window.first()].kappa = plan.nodes[window.node(1)].kappa;
}

void DrivenPlan::set_speeds(const LapWindow& window, double mu, LapPlan& plan) const {
  for (std::size_t k = 0; k < window.count(); ++k) {
    const std::size_t i = window.node(k);
    plan.nodes[i].v = v_[i] * std::min(1.0, std::sqrt(mu / mu_[i]));
  }
}

void DrivenPlan::slow_down(std::size_t node, double share) { v_[node] *= std::sqrt(share); }

}  // namespace gripline::time_optimal
