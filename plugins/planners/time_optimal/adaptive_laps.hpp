// A library of laps that follows what is learned: members near the present friction are solved anew when the learned
// tyres differ from those they were solved for (or the learned resistance does), and go over to the new lap in steps.
//
// A solve takes longer than a control step. So that a run does not depend on the machine, it is ordered in one step and
// its result is used as many steps later as its counted work takes at a stated rate, and never before a stated latency:
// as if another core had worked on it meanwhile.
//
// There is no other core: step() solves the whole lap within the control step that comes `latency` steps after the
// order, which allocates and takes as long as Ipopt does. Calls of every other step keep to the contract of plugins. A
// simulated race waits; a car that drives in real time needs receding_time, or these solves in a thread of their own.
#pragma once

#include <cstddef>
#include <vector>

#include "planners/time_optimal/lap_library.hpp"

namespace gripline::time_optimal {

struct AdaptiveOptions {
  double tolerance = 0.03;     // of tyre force over peak, or of resistance over weight, that makes a member out of date
  double slip_range = 0.6;     // over which tyres are compared [rad]
  int latency = 25;            // control steps between order and use, at least
  double work_per_step = 1e9;  // nodes times iterations that the other core gets done in a control step
  int transition = 25;         // control steps in which a member goes over to its new lap
};

class AdaptiveLaps {
 public:
  AdaptiveLaps(const LapSetup& setup, std::vector<LapMember> members, const AdaptiveOptions& options);

  /// One control step: ends and orders solves for the car learned (null: nothing is learned). Then `out` is the lap
  /// at this friction; below the first member's friction, the first member's lap.
  void step(const CarBelief* learned, double mu, LapPlan& out);
  /// The longest so far from an order to the first step of its lap [control steps].
  int longest_wait() const { return longest_wait_; }

 private:
  struct Transition {
    LapPlan from, now;
    int left = 0;  // steps
  };
  struct Order {
    std::size_t member = 0;
    CarBelief belief;
    int due = -1;  // steps until it is solved, or used when it was; -1: no order
    int wait = 0;  // steps since it was placed
    bool worked_on = false, solved = false;
  };
  void advance_order();
  void solve_order();
  void place_order(const CarBelief& learned, std::size_t nearest, std::size_t other);
  bool out_of_date(const CarBelief& learned, std::size_t member) const;
  void advance_transitions();

  const LapSetup* setup_;
  AdaptiveOptions options_;
  std::vector<LapMember> members_;
  std::vector<Transition> shown_;
  Order order_;
  int longest_wait_ = 0;
};

}  // namespace gripline::time_optimal
