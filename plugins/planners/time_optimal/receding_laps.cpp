#include "planners/time_optimal/receding_laps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "planners/time_optimal/lap_dynamics.hpp"
#include "planners/time_optimal/tyre_fit.hpp"

namespace gripline::time_optimal {
namespace {

constexpr double least_barrier = 2e-5, first_barrier = 1e-2;  // [s]
constexpr double restart_barrier = 1e-3;                      // of a window that was stuck (window_health.hpp)
constexpr double small_step = 0.02, small_defect = 2e-3;
constexpr double drivable_defect = 0.01;  // of dynamics and constraints, in typical sizes
// An iterate at a small barrier is a poor start for another problem: slacks that hold are next to zero.
constexpr double barrier_per_change = 0.01;                     // barrier over the change of the belief [s]
constexpr double least_change = 0.005, stalled_barrier = 2e-4;  // changes and stalls that raise it
constexpr double driven_barrier = 1e-4;  // of what is driven: it costs a part of that per constraint
// A plan that begins at a car which has left its last one: it may keep away further from constraints, obey the dynamics
// less well, takes more Newton steps and is followed faster: by this share of the way in 20 ms.
constexpr double off_plan_barrier = 1e-3, off_plan_defect = 0.03, off_plan_follow = 0.5;
constexpr int off_plan_work = 3;  // times the Newton steps of other control steps

// Nodes of a window that may be a large part of the lap. From the base line longer ones settle in laps with parts that
// are driven backwards, and one that never leaves such a part keeps it.
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
      lap_(setup, car.tyres),
      window_(setup, std::min(most_nodes_, short_window), options.ahead),
      driven_(setup, mu_),
      health_(options.dt) {
  tell_solver();
  solve_whole_lap();
  lap_.remember();
  window_ = LapWindow(setup, most_nodes_, options.ahead);
}

/// Windows that overlap, twice round: first from the base line with a falling barrier, then to the end. What depends on
/// how a window is made to end is solved again by the next one; the last ones, which reach round to the beginning,
/// leave that as it was solved before.
void RecedingLaps::solve_whole_lap() {
  for (const double barrier : {first_barrier, restart_barrier})
    for (std::size_t first = 0; first < lap_.size(); first += std::max<std::size_t>(1, window_.count() / 3)) {
      window_.place(first, lap_.nodes());
      const std::vector<WindowNode> before = lap_.nodes();
      solve_once(barrier);
      if (barrier == first_barrier) continue;
      const std::size_t stays = std::max(lap_.size(), first + window_.near_count());
      for (std::size_t i = stays; i <= first + window_.count(); ++i)
        lap_.nodes()[i % lap_.size()] = before[i % lap_.size()];
    }
}

/// The window, until it is settled at the least barrier.
void RecedingLaps::solve_once(double barrier) {
  constexpr int most = 80;
  begin_ = slowed(window_.first());
  end_ = slowed(window_.last());
  barrier_ = barrier;
  health_.restart();
  for (int i = 0; i < most; ++i)
    if (improve() && barrier_ <= least_barrier) break;
}

void RecedingLaps::move_window(double station) {
  const std::size_t first = window_.first_behind(station, lap_.nodes());
  if (window_.may_stay(first, lap_.nodes())) return;
  // A window that begins at a car which had left its plan does not move back: the nodes behind are of that plan.
  if (at_car_ && window_.is_just_behind(first)) return;
  place_window(first);
  at_car_ = false;
}

void RecedingLaps::place_window(std::size_t first) {
  if (window_.reaches(first)) {
    const std::size_t passed = window_.nodes_to(first);
    // Nodes that are left behind without a plan would be a poor start for the next lap.
    if (health_.is_lost())
      for (std::size_t k = 0; k < passed; ++k) lap_.reset(window_.node(k), mu_at(window_.node(k)));
    nodes_until_retry_ -= std::min(nodes_until_retry_, passed);
  }
  for (std::size_t k = window_.place(first, lap_.nodes()); k <= window_.count(); ++k)
    lap_.slow_down(window_.node(k), mu_at(window_.node(k)));
  begin_ = slowed(window_.first());
  end_ = slowed(window_.last());
  settled_ = false;
}

/// The window from the node behind a car on, as the car passed it.
void RecedingLaps::begin_at(const State& car, double station) {
  place_window(node_behind(*setup_, car, station));
  if (!was_off_plan_) barrier_ = std::max(barrier_, off_plan_barrier);
  at_car_ = true;
  nodes_until_retry_ = window_.near_count();
  begin_ = passed_with(*setup_, car, window_.first());
}

/// One Newton step. Where the first three quarters of the window are settled at its barrier, the barrier falls; true
/// where it was the least one. The last quarter settles before the car comes near to it.
bool RecedingLaps::improve() {
  const WindowStep step = solver_.iterate(lap_.nodes(), window_.first(), window_.count(), barrier_, begin_, end_);
  ++iterations_;
  defect_ = step.near_defect;
  health_.newton_step(step.good);
  if (!step.good) {
    ++failures_;
    if (health_.is_stuck()) start_again(restart_barrier);
    return false;
  }
  if (step.near_change > small_step || step.near_defect > small_defect || step.share < 0.5) return false;
  const bool last = barrier_ <= least_barrier;
  barrier_ = std::max(least_barrier, 0.2 * barrier_);
  return last;
}

/// A window may settle in a plan that nearly stops somewhere, and would keep it lap after lap. One that is slower than
/// the first lap would be at the friction of now, and much slower at one place, begins again from that, once on its
/// way.
void RecedingLaps::leave_a_plan_that_stops() {
  constexpr double slower = 1.15, nearly_stops = 0.4;
  if (nodes_until_retry_ > 0) return;
  double own = 0, first = 0, least = 1;
  for (std::size_t k = 0; k < window_.near_count(); ++k) {
    const std::size_t i = window_.node(k);
    const double here = time_over(i, lap_.at(i));
    const double then = time_over(i, lap_.remembered(i)) * std::sqrt(lap_.remembered_for() / mu_at(i));
    own += here;
    first += then;
    least = std::min(least, then / here);
  }
  if (!(own > slower * first && least < nearly_stops)) return;
  nodes_until_retry_ = window_.near_count();
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
  for (std::size_t k = 0; k <= window_.count(); ++k) lap_.reset(window_.node(k), mu_at(window_.node(k)));
  begin_ = lap_.at(window_.first());
  end_ = lap_.at(window_.last());
  barrier_ = barrier;
  defect_ = std::numeric_limits<double>::infinity();  // not known before the next step
  health_.restart();
}

/// The window at a share of the friction it was for.
void RecedingLaps::slow_window(double share) {
  begin_ = KeptLap::at_share(begin_, share);
  for (std::size_t k = 0; k <= window_.count(); ++k) lap_.scale(window_.node(k), share, mu_at(window_.node(k)));
  end_ = lap_.at(window_.last());
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
  if (grip < old) driven_.slow_down(node, grip / old);
  settled_ = false;
}

void RecedingLaps::set_slip_bound_slow_car(double slip) {
  if (slip <= solver_.slip_bound_slow_car()) return;
  solver_.set_slip_bound_slow_car(slip);
  tell_solver();
  settled_ = false;
}

void RecedingLaps::tell_solver() {
  const SpecificResistance& known = setup_->typical().resistance;
  solver_.set_car(car_.tyres, {car_.resistance.rolling - known.rolling, car_.resistance.drag - known.drag});
}

/// The car that is solved for goes towards the one believed: to less friction at once, else in steps that a warm start
/// bears, and then it waits for a window that does not obey the dynamics. A window that never does, as no car could
/// that is solved for, begins again with the car believed.
void RecedingLaps::advance_belief(const CarBelief& car, double spread) {
  constexpr double finest = 0.002;          // of tyre force over its peak, or of resistance over weight
  constexpr double largest = 0.02;          // in a control step, whatever its length: what Newton steps bear
  constexpr double share_of_spread = 0.25;  // by which a belief moves before anything is solved again
  if (!finite(car)) return;
  const double resolution = std::max(finest, share_of_spread * spread);
  double moved = difference_to(car);
  if (health_.is_given_up(moved)) {
    begin_again_for(car, moved);
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

void RecedingLaps::begin_again_for(const CarBelief& car, double moved) {
  health_.begin_for(moved);
  settled_ = following_ = false;
  car_ = car;
  mu_ = mu_of(car_.tyres);
  tell_solver();
  start_again(first_barrier);
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

void RecedingLaps::step(const CarBelief& car, double spread, double station, LapPlan& plan, const State* off_plan) {
  if (off_plan != nullptr)
    begin_at(*off_plan, station);
  else
    move_window(station);
  advance_belief(car, spread);
  if (off_plan != nullptr)
    begin_ = passed_with(*setup_, *off_plan, window_.first());  // not slower, whatever is believed
  was_off_plan_ = off_plan != nullptr;
  solve((off_plan != nullptr ? off_plan_work : 1) * options_.iterations);
  const bool drivable = settled_ || defect_ < drivable_defect;
  if (health_.control_step(drivable)) raise_barrier_of_a_stall();
  if (off_plan != nullptr) {
    if (defect_ < off_plan_defect && barrier_ <= off_plan_barrier)
      publish(plan, 0, share_of_way_in(options_.dt, off_plan_follow));
  } else if (drivable && barrier_ <= driven_barrier) {
    publish(plan, 1, share_of_way_in(options_.dt, options_.follow));
  }
  driven_.set_speeds(window_, mu_of(car.tyres), plan);
  changed_ = window_.count();
}

/// Newton steps until the window is settled.
void RecedingLaps::solve(int most_steps) {
  if (settled_) return;
  for (int i = 0; i < most_steps && !settled_; ++i) settled_ = improve();
  if (settled_) leave_a_plan_that_stops();
}

void RecedingLaps::raise_barrier_of_a_stall() {
  barrier_ = std::min(first_barrier, std::max(stalled_barrier, 5.0 * barrier_));
}

/// The driven plan goes a share of the way to the window's, from its node `from` (0 or 1) on.
void RecedingLaps::publish(LapPlan& plan, std::size_t from, double share) {
  driven_.follow(window_, lap_.nodes(), from, share, mu_, plan);
  for (std::size_t k = from; k < window_.near_count(); ++k)
    lap_.set_solved_for(window_.node(k), mu_at(window_.node(k)));
}

}  // namespace gripline::time_optimal
