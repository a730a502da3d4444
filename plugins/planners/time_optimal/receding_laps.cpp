#include "planners/time_optimal/receding_laps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "planners/time_optimal/tyre_fit.hpp"

namespace gripline::time_optimal {
namespace {

constexpr double least_barrier = 2e-5, first_barrier = 1e-2;  // [s]
constexpr double behind = 0.4;                                // [s] of window behind the car
constexpr double hold = 0.1;                                  // [s] that the car goes on before the window follows
constexpr double small_step = 0.02, small_defect = 2e-3;
constexpr double drivable_defect = 0.01;  // of dynamics and constraints, in typical sizes
// An iterate at a small barrier is a poor start for another problem: slacks that hold are next to zero.
constexpr double barrier_per_change = 0.01;                     // barrier over the change of the belief [s]
constexpr double least_change = 0.005, stalled_barrier = 2e-4;  // changes and stalls that raise it
constexpr double driven_barrier = 1e-4;  // of what is driven: it costs a part of that per constraint
constexpr int most_stalled = 15;         // control steps without a plan that can be driven
// A plan that begins at a car which has left its last one: it may keep away further from constraints, obey the dynamics less
// well, takes more Newton steps and is followed faster.
constexpr double astray_barrier = 1e-3, astray_defect = 0.03, astray_follow = 0.5;
constexpr int astray_work = 3;  // times the Newton steps of other control steps
// A window without a plan begins again after so many control steps, each time later by as many, up to the most; where
// the belief has moved by `other_car` (of tyre force over its peak, or of resistance over weight) after the fewest.
constexpr int first_patience = 50, most_patience = 150, least_patience = 25;
constexpr double other_car = 0.05;

// Nodes of a window that may be a large part of the lap. From the base line longer ones settle in laps with parts that are
// driven backwards, and one that never leaves such a part keeps it.
constexpr std::size_t short_window = 100;
std::size_t most_nodes(int asked, std::size_t lap) {
  return std::min({static_cast<std::size_t>(asked), std::max(short_window, lap / 2), lap - 2});
}

bool finite(const CarBelief& car) {
  const auto tyre = [](const vehicle::MagicFormula& t) { return t.B + t.C + t.D; };
  return std::isfinite(tyre(car.tyres.front) + tyre(car.tyres.rear) + car.resistance.rolling + car.resistance.drag);
}

}  // namespace

RecedingLaps::RecedingLaps(const LapSetup& setup, const CarBelief& car, const RecedingOptions& options)
    : setup_(&setup),
      options_(options),
      most_nodes_(most_nodes(options.nodes, setup.nodes().s.size())),
      solver_(setup.problem({car.tyres, setup.typical().resistance}), most_nodes_),
      car_(car),
      mu_(mu_of(car.tyres)),
      lap_(setup.nodes().s.size()),
      solved_for_(lap_.size(), mu_),
      driven_for_(lap_.size(), mu_),
      driven_v_(lap_.size()),
      heading_(lap_.size() + 2),
      patience_(first_patience) {
  first_lap_ = setup.cold_guess(car.tyres).z;
  first_mu_ = mu_;
  for (std::size_t k = 0; k < lap_.size(); ++k) lap_[k].z = first_lap_[k];
  const std::vector<double>& s = setup.nodes().s;
  bucket_.resize(s.size());
  for (std::size_t i = 0; i < bucket_.size(); ++i) {
    const double from = setup.base().length() * static_cast<double>(i) / static_cast<double>(bucket_.size());
    bucket_[i] = static_cast<std::size_t>(std::upper_bound(s.begin(), s.end(), from) - s.begin()) - 1;
  }
  for (const double station : s) base_at_.push_back(setup.base().at(station));
  tell_solver();
  solve_whole_lap();
  first_lap_.clear();
  for (const WindowNode& node : lap_) first_lap_.push_back(node.z);
}

std::size_t RecedingLaps::node_at(double station) const {
  const double s = wrap_periodic(station, setup_->base().length());
  const double share = s / setup_->base().length() * static_cast<double>(bucket_.size());
  std::size_t k = bucket_[std::min(static_cast<std::size_t>(share), bucket_.size() - 1)];
  while (k + 1 < lap_.size() && setup_->nodes().s[k + 1] <= s) ++k;
  return k;
}

std::size_t RecedingLaps::window_length(std::size_t first) const {
  constexpr std::size_t least = 30;
  double time = 0;
  std::size_t n = 0;
  while (n < most_nodes_ && (time < options_.ahead + behind || n < least)) {
    const std::size_t i = wrapped(first + n);
    time += setup_->nodes().ds[i] / std::max(lap_[i].z[lap_vx], 0.05 * setup_->top_speed());
    ++n;
  }
  return n;
}

/// Windows that overlap, twice round: first from the base line with a falling barrier, then to the end. What depends on how
/// a window is made to end is solved again by the next one; the last ones, which reach round to the beginning, leave that
/// as it was solved before.
void RecedingLaps::solve_whole_lap() {
  constexpr int most = 80;
  std::size_t stride = 1;
  for (int round = 0; round < 2; ++round)
    for (std::size_t first = 0; first < lap_.size(); first += stride) {
      count_ = std::min(window_length(first), short_window);
      stride = std::max<std::size_t>(1, count_ / 3);
      first_ = first;
      begin_ = kept(first);
      end_ = kept(wrapped(first + count_));
      barrier_ = round == 0 ? first_barrier : 1e-3;
      failed_ = 0;
      const std::vector<WindowNode> before = lap_;
      for (int i = 0; i < most; ++i)
        if (improve() && barrier_ <= least_barrier) break;
      if (round == 0) continue;
      const std::size_t stays = std::max(lap_.size(), first + WindowSolver::near_part(count_));
      for (std::size_t i = stays; i <= first + count_; ++i) lap_[wrapped(i)] = before[wrapped(i)];
    }
}

/// The state kept at a node, slowed down where it was solved for more friction than there is now.
RecedingLaps::States RecedingLaps::kept(std::size_t node) const {
  States z = lap_[node].z;
  const double slower = std::min(1.0, std::sqrt(mu_at(node) / std::max(solved_for_[node], 1e-6)));
  for (const int j : {lap_vx, lap_vy, lap_omega}) z[static_cast<std::size_t>(j)] *= slower;
  return z;
}

/// Time that the kept lap takes from a node on to another [s]; infinite where that is more than half a lap.
double RecedingLaps::time_between(std::size_t from, std::size_t to) const {
  double time = 0;
  for (std::size_t i = from, n = 0; i != to; i = wrapped(i + 1), ++n) {
    if (time > hold || n > lap_.size() / 2) return std::numeric_limits<double>::infinity();
    time += setup_->nodes().ds[i] / std::max(lap_[i].z[lap_vx], 0.05 * setup_->top_speed());
  }
  return time;
}

void RecedingLaps::move_window(double station) {
  std::size_t first = node_at(station);
  double back = 0;
  for (std::size_t i = 0; i < lap_.size() / 8 && back < behind; ++i) {
    first = first > 0 ? first - 1 : lap_.size() - 1;
    back += setup_->nodes().ds[first] / std::max(lap_[first].z[lap_vx], 0.05 * setup_->top_speed());
  }
  if (placed_ && time_between(first_, first) < hold) return;
  // What lies behind a car that had left its plan is of that plan.
  if (at_car_ && wrapped(first_ + lap_.size() - first) < lap_.size() / 8) return;
  place_window(first);
  at_car_ = false;
}

void RecedingLaps::place_window(std::size_t first) {
  const std::size_t old_end = wrapped(first_ + count_);
  const bool onward = placed_ && wrapped(first + lap_.size() - first_) < count_;
  // What is left behind without a plan is no start for the next lap.
  if (onward && lost_ > least_patience)
    for (std::size_t i = first_; i != first; i = wrapped(i + 1)) reset(i);
  if (onward) nodes_until_retry_ -= std::min(nodes_until_retry_, wrapped(first + lap_.size() - first_));
  first_ = first;
  count_ = window_length(first);
  // What the window did not reach before, which may be nothing.
  const std::size_t fresh = onward ? wrapped(old_end + lap_.size() - first) : 0;
  for (std::size_t k = fresh; k <= count_; ++k) slow_down(wrapped(first + k));
  begin_ = kept(first);
  end_ = kept(wrapped(first + count_));
  settled_ = false;
  placed_ = true;
}

/// The window from the node behind a car on, as the car passed it.
void RecedingLaps::begin_at(const State& car, double station) {
  const LinePoint beside = setup_->base().at(station);
  const double sine = std::sin(beside.yaw), cosine = std::cos(beside.yaw), dx = car.x - beside.x, dy = car.y - beside.y;
  const double n = cosine * dy - sine * dx, along = cosine * dx + sine * dy;
  place_window(node_at(station + along / std::max(0.2, 1.0 - n * beside.kappa)));
  if (!was_astray_) barrier_ = std::max(barrier_, astray_barrier);
  at_car_ = true;
  nodes_until_retry_ = WindowSolver::near_part(count_);
  begin_ = passed(first_, car);
}

/// The state in which a car passed the node behind it: back along an arc, at the speeds that it has now.
RecedingLaps::States RecedingLaps::passed(std::size_t node, const State& car) const {
  constexpr double steepest = 1.0;  // [rad]
  const LinePoint at = setup_->base().at(setup_->nodes().s[node]);
  const double sine = std::sin(at.yaw), cosine = std::cos(at.yaw), dx = car.x - at.x, dy = car.y - at.y;
  const double along = cosine * dx + sine * dy, askew = std::remainder(car.yaw - at.yaw, 2.0 * std::numbers::pi);
  const double turned = along * car.omega / std::max(std::hypot(car.vx, car.vy), setup_->car().v_min);
  const double course = std::clamp(askew + std::atan2(car.vy, car.vx) - 0.5 * turned, -steepest, steepest);
  States z{};
  z[lap_n] = cosine * dy - sine * dx - along * std::tan(course);
  z[lap_xi] = askew - turned;
  z[lap_vx] = car.vx;
  z[lap_vy] = car.vy;
  z[lap_omega] = car.omega;
  z[lap_delta] = car.delta;
  return z;
}

/// One Newton step; whether the window is settled at its barrier, which then falls.
bool RecedingLaps::improve() {
  const WindowStep step = solver_.iterate(lap_, first_, count_, barrier_, begin_, end_);
  ++iterations_;
  defect_ = step.near_defect;
  if (!step.good) {
    ++failures_;
    if (++failed_ > 8) start_again(1e-3);
    return false;
  }
  failed_ = 0;
  if (step.near_change > small_step || step.near_defect > small_defect || step.share < 0.5) return false;
  const bool last = barrier_ <= least_barrier;  // the far part settles before the car comes near to it
  barrier_ = std::max(least_barrier, 0.2 * barrier_);
  return last;
}

/// A window may settle in a plan that nearly stops somewhere, and would keep it lap after lap. One that is slower than the
/// first lap would be at the friction of now, and much slower at one place, begins again from that, once on its way.
void RecedingLaps::leave_a_plan_that_stops() {
  constexpr double slower = 1.15, nearly_stops = 0.4;
  const std::size_t near = WindowSolver::near_part(count_);
  if (nodes_until_retry_ > 0) return;
  double own = 0, first = 0, least = 1;
  for (std::size_t k = 0; k < near; ++k) {
    const std::size_t i = wrapped(first_ + k);
    const double here = time_over(i, lap_[i].z);
    const double then = time_over(i, first_lap_[i]) * std::sqrt(first_mu_ / mu_at(i));
    own += here;
    first += then;
    least = std::min(least, then / here);
  }
  if (!(own > slower * first && least < nearly_stops)) return;
  nodes_until_retry_ = near;
  settled_ = false;
  start_again(first_barrier);
}

/// What an interval takes at a state [s].
double RecedingLaps::time_over(std::size_t i, const States& z) const {
  const double along = z[lap_vx] * std::cos(z[lap_xi]) - z[lap_vy] * std::sin(z[lap_xi]);
  const double way = setup_->nodes().ds[i] * (1.0 - setup_->nodes().places[i].kappa * z[lap_n]);
  return way / std::max(along, 0.01 * setup_->top_speed());
}

/// The window from the states of the first lap, slowed down to the friction of now, with fresh slacks and multipliers.
void RecedingLaps::start_again(double barrier) {
  for (std::size_t k = 0; k <= count_; ++k) reset(wrapped(first_ + k));
  begin_ = lap_[first_].z;
  end_ = lap_[wrapped(first_ + count_)].z;
  barrier_ = barrier;
  defect_ = std::numeric_limits<double>::infinity();  // not known before the next step
  failed_ = 0;
}

/// A node as it was in the first lap, slowed down to the friction of now.
void RecedingLaps::reset(std::size_t i) {
  lap_[i].started = false;
  lap_[i].pi = {};
  lap_[i].z = first_lap_[i];
  solved_for_[i] = first_mu_;
  lap_[i].z = kept(i);
  solved_for_[i] = std::min(first_mu_, mu_at(i));
}

/// A node that the window reaches, kept for more friction than is believed now.
void RecedingLaps::slow_down(std::size_t i) {
  const double mu = mu_at(i);
  if (mu >= 0.97 * solved_for_[i]) return;
  lap_[i].z = kept(i);
  lap_[i].z[lap_a] *= mu / solved_for_[i];
  solved_for_[i] = mu;
}

/// The window at a share of the friction it was for. But for resistances and limits of drive and brakes the car's
/// motion is the same then, along the same way with the same slips, at speeds lower by the share's square root: the
/// window stays as good as it was.
void RecedingLaps::slow_window(double share) {
  const double slower = std::sqrt(share);
  for (const int j : {lap_vx, lap_vy, lap_omega}) begin_[static_cast<std::size_t>(j)] *= slower;
  for (std::size_t k = 0; k <= count_; ++k) {
    const std::size_t i = wrapped(first_ + k);
    WindowNode& node = lap_[i];
    for (const int j : {lap_vx, lap_vy, lap_omega, lap_rate}) node.z[static_cast<std::size_t>(j)] *= slower;
    node.z[lap_a] *= share;
    // Time per typical size: of ways and angles it grows as time does, of speeds once more.
    for (const int j : {lap_n, lap_xi, lap_delta}) node.pi[static_cast<std::size_t>(j)] /= slower;
    for (const int j : {lap_vx, lap_vy, lap_omega}) node.pi[static_cast<std::size_t>(j)] /= share;
    solved_for_[i] = std::min(solved_for_[i], mu_at(i));
  }
  end_ = lap_[wrapped(first_ + count_)].z;
}

double RecedingLaps::difference_to(const CarBelief& car) const {
  const double v = 0.5 * setup_->top_speed();
  return std::max(difference(car_.tyres, car.tyres, solver_.largest_slip()),
                  std::abs(car.resistance.at(v) - car_.resistance.at(v)) / gravity);
}

/// A plan that was for more is driven more slowly there at once.
void RecedingLaps::set_grip(std::size_t node, double grip) {
  const double old = solver_.problem().places[node].grip;
  if (grip == old) return;
  solver_.set_grip(node, grip);
  if (grip < old) driven_v_[node] *= std::sqrt(grip / old);
  settled_ = false;
}

void RecedingLaps::set_slip_most(double slip) {
  if (slip <= solver_.slip_most()) return;
  solver_.set_slip_most(slip);
  tell_solver();
  settled_ = false;
}

void RecedingLaps::tell_solver() {
  const SpecificResistance& known = setup_->typical().resistance;
  solver_.set_car(car_.tyres, {car_.resistance.rolling - known.rolling, car_.resistance.drag - known.drag});
}

bool RecedingLaps::begin_again_is_due(double moved) const {
  return lost_ > patience_ || (lost_ > least_patience && moved > other_car);
}

/// The car that is solved for goes towards the one believed: to less friction at once, else in steps that a warm start
/// bears, and then it waits for a window that does not obey the dynamics. A window that never does, as no car could that
/// is solved for, begins again with the car believed.
void RecedingLaps::advance_belief(const CarBelief& car, double spread) {
  constexpr double finest = 0.002;          // of tyre force over its peak, or of resistance over weight
  constexpr double largest = 0.02;          // in a control step
  constexpr double share_of_spread = 0.25;  // by which a belief moves before anything is solved again
  if (!finite(car)) return;
  const double resolution = std::max(finest, share_of_spread * spread);
  double moved = difference_to(car);
  if (begin_again_is_due(moved)) {
    patience_ = moved > other_car ? first_patience : std::min(patience_ + first_patience, most_patience);
    lost_ = 0;
    settled_ = following_ = false;
    car_ = car;
    mu_ = mu_of(car_.tyres);
    tell_solver();
    start_again(first_barrier);
    return;
  }
  following_ = moved > (following_ ? 0.5 : 1.0) * resolution;
  if (!following_) return;
  settled_ = false;
  const double less = mu_of(car.tyres) / mu_;
  if (less < 1.0) {
    car_.tyres = scaled_to(car_.tyres, less * mu_);
    mu_ = mu_of(car_.tyres);
    slow_window(less);
    moved = difference_to(car);
  }
  if (defect_ <= 10.0 * drivable_defect) {
    const double share = std::min(1.0, largest / std::max(moved, 1e-9)), change = share * moved;
    if (change > least_change) barrier_ = std::max(barrier_, barrier_per_change * change);
    approach(car, share);
  }
  tell_solver();
}

/// A share of the way to another car.
void RecedingLaps::approach(const CarBelief& car, double share) {
  const auto towards = [share](double& value, double wanted) { value += share * (wanted - value); };
  for (const auto& [own, wanted] :
       {std::pair(&car_.tyres.front, &car.tyres.front), std::pair(&car_.tyres.rear, &car.tyres.rear)}) {
    towards(own->B, wanted->B);
    towards(own->C, wanted->C);
    towards(own->D, wanted->D);
  }
  towards(car_.resistance.rolling, car.resistance.rolling);
  towards(car_.resistance.drag, car.resistance.drag);
  mu_ = mu_of(car_.tyres);
}

void RecedingLaps::step(const CarBelief& car, double spread, double station, LapPlan& plan, const State* astray) {
  if (astray != nullptr)
    begin_at(*astray, station);
  else
    move_window(station);
  advance_belief(car, spread);
  if (astray != nullptr) begin_ = passed(first_, *astray);  // not slower, whatever is believed
  was_astray_ = astray != nullptr;
  const int most = (astray != nullptr ? astray_work : 1) * options_.iterations;
  const bool unsettled = !settled_;
  for (int i = 0; i < most && !settled_; ++i) settled_ = improve();
  if (unsettled && settled_) leave_a_plan_that_stops();
  const bool drivable = settled_ || defect_ < drivable_defect;
  stalled_ = drivable ? 0 : stalled_ + 1;
  lost_ = drivable ? 0 : lost_ + 1;
  if (drivable) patience_ = first_patience;
  if (stalled_ > most_stalled) {
    barrier_ = std::min(first_barrier, std::max(stalled_barrier, 5.0 * barrier_));
    stalled_ = 0;
  }
  if (astray != nullptr) {
    if (defect_ < astray_defect && barrier_ <= astray_barrier) publish(plan, 0, astray_follow);
  } else if (drivable && barrier_ <= driven_barrier) {
    publish(plan, 1, options_.follow);
  }
  // Where friction is believed to be less than what the plan is for, it is driven more slowly at once.
  const double mu = mu_of(car.tyres);
  changed_ = count_;
  for (std::size_t k = 0; k < changed_; ++k) {
    const std::size_t i = wrapped(first_ + k);
    plan.nodes[i].v = driven_v_[i] * std::min(1.0, std::sqrt(mu / driven_for_[i]));
  }
}

/// As make_plan(), of one node.
LapPlan::Node RecedingLaps::plan_node(std::size_t i) const {
  const std::size_t before = i > 0 ? i - 1 : lap_.size() - 1, after = wrapped(i + 1);
  const States &p = lap_[before].z, &z = lap_[i].z, &q = lap_[after].z;
  const double h0 = setup_->nodes().ds[before], h1 = setup_->nodes().ds[i];
  const double slope0 = (z[lap_n] - p[lap_n]) / h0, slope1 = (q[lap_n] - z[lap_n]) / h1;
  const auto mean = [&](std::size_t j) { return 0.25 * (p[j] + 2.0 * z[j] + q[j]); };
  const double vx = mean(lap_vx), vy = mean(lap_vy);
  return {z[lap_n], (h1 * slope0 + h0 * slope1) / (h0 + h1), std::hypot(vx, vy), std::atan2(vy, vx), 0.0};
}

/// Curvature of the path at `count` nodes from `first` on (indices wrap).
void RecedingLaps::set_curvatures(LapPlan& plan, std::size_t first, std::size_t count) {
  const std::size_t before = first > 0 ? first - 1 : lap_.size() - 1;
  for (std::size_t k = 0; k < count + 2; ++k) {
    const std::size_t i = wrapped(before + k);
    heading_[k] = path_heading(base_at_[i], plan.nodes[i], setup_->nodes().ds[i]);
  }
  for (std::size_t k = 0; k < count; ++k)
    plan.nodes[wrapped(first + k)].kappa = path_curvature(heading_[k], heading_[k + 1], heading_[k + 2]);
}

/// As plan_node(), of the window's first node: there is none before it.
LapPlan::Node RecedingLaps::first_node() const {
  const States &z = lap_[first_].z, &q = lap_[wrapped(first_ + 1)].z;
  const double slope = (q[lap_n] - z[lap_n]) / setup_->nodes().ds[first_];
  return {z[lap_n], slope, std::hypot(z[lap_vx], z[lap_vy]), std::atan2(z[lap_vy], z[lap_vx]), 0.0};
}

/// The driven plan goes a share of the way to the window's, from its node `from` (0 or 1) on.
void RecedingLaps::publish(LapPlan& plan, std::size_t from, double follow) {
  const auto between = [follow](double a, double b) { return a + follow * (b - a); };
  const std::size_t count = WindowSolver::near_part(count_);
  for (std::size_t k = from; k < count; ++k) {
    const std::size_t i = wrapped(first_ + k);
    LapPlan::Node& p = plan.nodes[i];
    const LapPlan::Node q = k > 0 ? plan_node(i) : first_node();
    p = {between(p.n, q.n), between(p.slope, q.slope), p.v, between(p.beta, q.beta), p.kappa};
    driven_v_[i] = between(driven_v_[i], q.v);
    driven_for_[i] = between(driven_for_[i], mu_);
    solved_for_[i] = mu_at(i);
  }
  const std::size_t ahead = from == 0 ? 1 : 0;
  set_curvatures(plan, wrapped(first_ + ahead), count + 1 - ahead);
  // Before a plan that begins at the car there is another one.
  if (from == 0) plan.nodes[first_].kappa = plan.nodes[wrapped(first_ + 1)].kappa;
}

LapPlan RecedingLaps::whole_plan() {
  LapPlan plan;
  for (std::size_t i = 0; i < lap_.size(); ++i) plan.nodes.push_back(plan_node(i));
  set_curvatures(plan, 0, lap_.size());
  for (std::size_t i = 0; i < lap_.size(); ++i) driven_v_[i] = plan.nodes[i].v;
  for (std::size_t i = 0; i < lap_.size(); ++i) plan.time += setup_->nodes().ds[i] / plan.nodes[i].v;
  return plan;
}

}  // namespace gripline::time_optimal
