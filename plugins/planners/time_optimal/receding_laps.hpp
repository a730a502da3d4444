// A lap that is always being solved for what is believed now, a window ahead of the car at a time: work per control
// step does not grow with the road, and nothing is allocated.
//
// The whole lap is kept as the iterate of its program (kept_lap.hpp). A window of it, from a little behind the car to
// `ahead` seconds ahead of it (lap_window.hpp), gets `iterations` Newton steps per control step (window_solver.hpp); it
// begins and ends near the states kept there. The plan follows a window whose first three quarters obey the dynamics
// and whose barrier is small, in steps; until then the old one is driven, more slowly where friction is believed to be
// less than what it is for (driven_plan.hpp). Here stands what is solved for, and when: a change of the belief raises
// the barrier, as does a window that finds no plan, since at a small one an iterate is a poor start for another
// problem.
//
// Nothing is solved where nothing changed: a window stays until the car is a tenth of a second further, one whose first
// three quarters are settled rests, and a belief that moved by less than its resolution, a quarter of its standard
// deviation, is the old one. Less friction is followed at once: the same motion at lower speeds.
//
// A car that has left its plan, too fast for it or wide of it, begins another: the window then begins with the car's
// own state, in every control step, and the plan is driven as soon as it can be. Where no plan could begin there, the
// quadratic penalty of the begin finds the nearest state with one (window_solver.hpp).
//
// A belief need not be one of a car that can be driven. While no plan is found the old one is driven; the window begins
// again now and then from the first lap, for the belief of that moment (window_health.hpp), sooner when the belief has
// moved.
#pragma once

#include <cstddef>

#include "planners/time_optimal/driven_plan.hpp"
#include "planners/time_optimal/kept_lap.hpp"
#include "planners/time_optimal/lap_plan.hpp"
#include "planners/time_optimal/lap_setup.hpp"
#include "planners/time_optimal/lap_window.hpp"
#include "planners/time_optimal/window_health.hpp"
#include "planners/time_optimal/window_solver.hpp"

namespace gripline::time_optimal {

struct RecedingOptions {
  double ahead = 6.0;    // [s] of plan
  int nodes = 200;       // most of a window; beyond 100 no more than half of the lap's
  int iterations = 2;    // Newton steps in a control step, at most
  double follow = 0.05;  // share of the way to a settled window that the driven plan goes in 20 ms, above 0
  double dt = 0.02;      // [s] of a control step
};

class RecedingLaps {
 public:
  /// Solves the whole lap for `car` once, window by window.
  RecedingLaps(const LapSetup& setup, const CarBelief& car, const RecedingOptions& options);

  /// One control step at a station of the base line, for this car; `spread` is the standard deviation of its friction
  /// over that friction. Changes the nodes of `plan` from changed_first() on. `off_plan`: the car, if it has left its
  /// plan; it is beside that station then.
  void step(const CarBelief& car, double spread, double station, LapPlan& plan, const State* off_plan = nullptr);
  /// Plans slips of a slow car (TyreUse) up to this angle from the next step on [rad]; no less than the setup's.
  void set_slip_bound_slow_car(double slip);
  std::size_t changed_first() const { return window_.first(); }
  std::size_t changed_count() const { return changed_; }

  /// Friction of the interval that begins at a node, over that of the car.
  void set_grip(std::size_t node, double grip);

  /// The plan of the whole lap as it is kept: what step() changes from then on.
  LapPlan whole_plan() { return driven_.whole(lap_.nodes()); }
  /// Newton steps so far, and those that found nothing better.
  long iterations() const { return iterations_; }
  long failures() const { return failures_; }
  /// Barrier of the interior-point method on the window now [s].
  double barrier() const { return barrier_; }

 private:
  using States = KeptLap::States;
  /// Friction at a node, of the car that is solved for.
  double mu_at(std::size_t node) const { return mu_ * solver_.problem().places[node].grip; }
  States slowed(std::size_t node) const { return lap_.slowed(node, mu_at(node)); }
  void solve_whole_lap();
  void solve_once(double barrier);

  // Where is solved.
  void move_window(double station);
  void begin_at(const State& car, double station);
  void place_window(std::size_t first);

  // What is solved for.
  void advance_belief(const CarBelief& car, double spread);
  void begin_again_for(const CarBelief& car, double moved);
  void approach(const CarBelief& car, double share);
  void slow_window(double share);
  double difference_to(const CarBelief& car) const;
  void tell_solver();

  // How it is solved.
  void solve(int most_steps);
  bool improve();
  void start_again(double barrier);
  void leave_a_plan_that_stops();
  double time_over(std::size_t interval, const States& z) const;
  void raise_barrier_of_a_stall();

  void publish(LapPlan& plan, std::size_t from, double share);

  const LapSetup* setup_;
  RecedingOptions options_;
  std::size_t most_nodes_;  // of a window
  WindowSolver solver_;
  CarBelief car_;  // that is solved for
  double mu_ = 0;  // of car_
  KeptLap lap_;
  LapWindow window_;
  DrivenPlan driven_;
  States begin_{}, end_{};  // near which the window begins and ends
  std::size_t changed_ = 0;
  double barrier_ = 0, defect_ = 0;
  WindowHealth health_;
  bool settled_ = false;
  std::size_t nodes_until_retry_ = 0;  // nodes that the window moves on before it may begin again from the first lap
  bool was_off_plan_ = false;          // the car, in the last control step
  bool at_car_ = false;                // the window began at a car that had left its plan, and has not moved on since
  bool following_ = false;             // the car that is solved for goes towards the one believed
  long iterations_ = 0, failures_ = 0;
};

}  // namespace gripline::time_optimal
