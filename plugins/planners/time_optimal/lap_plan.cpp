#include "planners/time_optimal/lap_plan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/planning/closed_line.hpp"

namespace gripline::time_optimal {

namespace {

bool same_path(const LapPlan::Node& a, const LapPlan::Node& b) {
  return a.n == b.n && a.slope == b.slope && a.kappa == b.kappa;
}

/// An angle between half a turn to the left and half a turn to the right; most are, and need no division [rad].
double within_half_turn(double angle) {
  return std::abs(angle) <= std::numbers::pi ? angle : std::remainder(angle, 2.0 * std::numbers::pi);
}

/// Heading of a plan's path at a node [rad], and its way per metre of the base line.
struct PathHeading {
  double yaw, stretch;
};
PathHeading path_heading(const LapSetup& setup, const LapPlan& plan, std::size_t i) {
  const LinePoint& base = setup.base_at(i);
  const LapPlan::Node& node = plan.nodes[i];
  const double along = 1.0 - node.n * base.kappa;
  return {base.yaw + std::atan2(node.slope, along), std::hypot(along, node.slope)};
}

}  // namespace

void set_curvatures(const LapSetup& setup, std::size_t first, std::size_t count, LapPlan& plan) {
  std::size_t i = first, last = setup.before(first);
  PathHeading before = path_heading(setup, plan, last), here = path_heading(setup, plan, first);
  double way_before = 0.5 * (before.stretch + here.stretch) * setup.nodes().ds[last];
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t next = setup.after(i);
    const PathHeading after = path_heading(setup, plan, next);
    const double way_after = 0.5 * (here.stretch + after.stretch) * setup.nodes().ds[i];
    plan.nodes[i].kappa = within_half_turn(after.yaw - before.yaw) / (way_before + way_after);
    before = here;
    here = after;
    way_before = way_after;
    i = next;
  }
}

/// The midpoint rule fixes differences of n and means of the other states; what alternates from node to node is
/// invisible to it. Hence slopes of n are those of the parabola through three nodes, other states are averaged.
LapPlan::Node plan_node(const LapSetup& setup, std::size_t i, const std::array<double, lap_variables>& before,
                        const std::array<double, lap_variables>& here, const std::array<double, lap_variables>& after) {
  const double ds_before = setup.nodes().ds[setup.before(i)], ds_after = setup.nodes().ds[i];
  const double slope_before = (here[lap_n] - before[lap_n]) / ds_before;
  const double slope_after = (after[lap_n] - here[lap_n]) / ds_after;
  const double slope = (ds_after * slope_before + ds_before * slope_after) / (ds_before + ds_after);
  const auto mean = [&](std::size_t i) { return 0.25 * (before[i] + 2.0 * here[i] + after[i]); };
  const double vx = mean(lap_vx), vy = mean(lap_vy);
  return {here[lap_n], slope, std::hypot(vx, vy), std::atan2(vy, vx), 0.0};
}

LapPlan make_plan(const LapSetup& setup, const LapSolution& solution) {
  LapPlan plan;
  plan.time = solution.time;
  const auto& z = solution.z;
  for (std::size_t i = 0; i < z.size(); ++i)
    plan.nodes.push_back(plan_node(setup, i, z[setup.before(i)], z[i], z[setup.after(i)]));
  set_curvatures(setup, 0, z.size(), plan);
  return plan;
}

void interpolate(const LapPlan& a, const LapPlan& b, double weight, LapPlan& out) {
  const auto between = [weight](double from, double to) { return from + (to - from) * weight; };
  out.nodes.resize(a.nodes.size());
  for (std::size_t k = 0; k < a.nodes.size(); ++k) {
    const LapPlan::Node &p = a.nodes[k], &q = b.nodes[k];
    out.nodes[k] = {between(p.n, q.n), between(p.slope, q.slope), between(p.v, q.v), between(p.beta, q.beta),
                    between(p.kappa, q.kappa)};
  }
  out.time = between(a.time, b.time);
}

PlanFollower::PlanFollower(const LapSetup& setup) : setup_(&setup), base_(&setup.base()), nodes_(&setup.nodes()) {
  const std::vector<double>& s = nodes_->s;
  for (std::size_t k = 0; k < s.size(); ++k)
    for (std::size_t j = 0; j < samples_per_interval; ++j) {
      const double at = s[k] + nodes_->ds[k] * static_cast<double>(j) / samples_per_interval;
      base_samples_.push_back(base_->at(at));
      base_samples_.back().station = base_->samples()[base_->bracket(at).first].station;
      base_heading_.push_back({std::sin(base_samples_.back().yaw), std::cos(base_samples_.back().yaw)});
    }
  samples_ = base_samples_;
}

/// Cubic Hermite between the nodes; derivatives by station of the base line.
PlanFollower::Offset PlanFollower::offset(std::size_t k, double u) const {
  const LapPlan::Node& p = plan_.nodes[k];
  const LapPlan::Node& q = plan_.nodes[setup_->after(k)];
  const double h = nodes_->ds[k], rise = q.n - p.n, a = p.slope * h, b = q.slope * h;
  const double c2 = 3.0 * rise - 2.0 * a - b, c3 = a + b - 2.0 * rise;
  return {p.n + u * (a + u * (c2 + u * c3)), (a + u * (2.0 * c2 + 3.0 * u * c3)) / h};
}

void PlanFollower::set(const LapPlan& plan) {
  plan_.nodes.assign(plan.nodes.begin(), plan.nodes.end());
  plan_.time = plan.time;
  for (std::size_t i = 0; i < samples_.size(); ++i) place_sample(i);
  measure_samples(0);
}

/// Speeds and sideslip angles change in every step, the path only where another plan is followed: samples are of the
/// path.
void PlanFollower::set(const LapPlan& plan, std::size_t first, std::size_t count) {
  const std::size_t n = plan_.nodes.size();
  std::size_t first_moved = n;
  const auto place = [&](std::size_t interval) {
    place_interval(interval);
    first_moved = std::min(first_moved, interval);
  };
  bool moved_before = false;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = (first + k) % n;
    const bool moved = !same_path(plan_.nodes[i], plan.nodes[i]);
    plan_.nodes[i] = plan.nodes[i];
    if (moved || moved_before) place(setup_->before(i));
    moved_before = moved;
  }
  if (moved_before) place((first + count - 1) % n);
  measure_samples(first_moved * samples_per_interval);
}

void PlanFollower::place_interval(std::size_t k) {
  for (std::size_t j = 0; j < samples_per_interval; ++j) place_sample(k * samples_per_interval + j);
}

PlanPoint PlanFollower::at(double station) const {
  const double s = wrap_periodic(station, base_->length());
  const std::size_t k = setup_->node_at(s);
  const double u = (s - nodes_->s[k]) / nodes_->ds[k];
  const Offset o = offset(k, u);
  const LinePoint p = base_->at(s);
  const LapPlan::Node& a = plan_.nodes[k];
  const LapPlan::Node& b = plan_.nodes[setup_->after(k)];
  const double along = 1.0 - o.n * p.kappa;
  PlanPoint r;
  r.x = p.x - o.n * std::sin(p.yaw);
  r.y = p.y + o.n * std::cos(p.yaw);
  r.yaw = p.yaw + std::atan2(o.slope, along);
  r.stretch = std::hypot(along, o.slope);
  r.kappa = a.kappa + (b.kappa - a.kappa) * u;
  r.v = a.v + (b.v - a.v) * u;
  r.beta = a.beta + (b.beta - a.beta) * u;
  return r;
}

void PlanFollower::place_sample(std::size_t i) {
  const std::size_t k = i / samples_per_interval;
  const double u = static_cast<double>(i % samples_per_interval) / samples_per_interval;
  const Offset o = offset(k, u);
  const LinePoint& p = base_samples_[i];
  LinePoint& r = samples_[i];
  const double along = 1.0 - o.n * p.kappa;
  r.x = p.x - o.n * base_heading_[i].sine;
  r.y = p.y + o.n * base_heading_[i].cosine;
  r.yaw = within_half_turn(p.yaw + std::atan2(o.slope, along));
  r.kappa = std::lerp(plan_.nodes[k].kappa, plan_.nodes[setup_->after(k)].kappa, u);
  r.left = p.left - o.n;
  r.right = p.right + o.n;
}

/// Stations of the samples along the path, from a sample on: those before it have not moved.
void PlanFollower::measure_samples(std::size_t from) {
  for (std::size_t i = from; i < samples_.size(); ++i) {
    LinePoint& r = samples_[i];
    r.s = i > 0 ? samples_[i - 1].s + std::hypot(r.x - samples_[i - 1].x, r.y - samples_[i - 1].y) : 0.0;
  }
}

/// Newton's method on (P(s) - p) . P'(s) = 0. Near the centre of the path's turns, where every point is a foot, its
/// steps are bounded.
double PlanFollower::refine(double s, double x, double y) const {
  for (int i = 0; i < 8; ++i) {
    const PlanPoint p = at(s);
    const double sine = std::sin(p.yaw), cosine = std::cos(p.yaw);
    const double ahead = (x - p.x) * cosine + (y - p.y) * sine, left = (y - p.y) * cosine - (x - p.x) * sine;
    const double most = 0.05 * base_->length();
    s += std::clamp(ahead / (p.stretch * std::max(0.5, 1.0 - left * p.kappa)), -most, most);
  }
  return wrap_periodic(s, base_->length());
}

/// The foot of a car far off, given its foot on the base line. A plan that lies askew to that line has another foot:
/// the farther the car, the farther from it. References that began there would lie behind the car.
double PlanFollower::beside_plan(double near, double x, double y) const {
  const auto distance = [&](double s) {
    const PlanPoint p = at(s);
    return std::hypot(x - p.x, y - p.y);
  };
  const double s = refine(near, x, y), moved = std::remainder(s - near, base_->length());
  const double off = distance(near);
  return std::abs(moved) < off && distance(s) <= off ? s : near;
}

double PlanFollower::locate(double x, double y, double yaw) {
  const auto distance = [&](const PlanPoint& p) { return std::hypot(x - p.x, y - p.y); };
  if (!std::isnan(hint_)) {
    const LinePoint road = base_->at(hint_);
    const double width = road.left + road.right;
    const double s = refine(hint_, x, y);
    const double jump = std::remainder(s - hint_, base_->length());
    if (distance(at(s)) <= width && std::abs(jump) <= 2.0 * width) return hint_ = s;
    // The car is further off than the road is wide, or its foot jumped: it is on another stretch, or beside this one.
    const double other = base_->project(x, y).s;
    if (!planning::is_between_edges(base_->at(other), x, y))
      return hint_ = beside_plan(base_->project(x, y, hint_).s, x, y);
  }
  std::size_t best = planning::nearest_sample(samples_, x, y);
  if (std::isnan(hint_)) best = planning::sample_facing(samples_, best, x, y, yaw);
  const std::size_t k = best / samples_per_interval;
  const double s =
      nodes_->s[k] + nodes_->ds[k] * static_cast<double>(best % samples_per_interval) / samples_per_interval;
  return hint_ = refine(s, x, y);
}

}  // namespace gripline::time_optimal
