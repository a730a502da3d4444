// The plan that is driven while the lap is being solved: it follows what windows find, and is driven more slowly at
// once where friction is believed to be less than what it is for.
#pragma once

#include <cstddef>
#include <vector>

#include "planners/time_optimal/lap_plan.hpp"
#include "planners/time_optimal/lap_window.hpp"
#include "planners/time_optimal/window_solver.hpp"

namespace gripline::time_optimal {

/// Share of the way that is gone in `dt` seconds, where `share` of what is left of it is gone in 20 ms.
double share_of_way_in(double dt, double share);

class DrivenPlan {
 public:
  /// For a lap at this friction.
  DrivenPlan(const LapSetup& setup, double mu);

  /// The plan of a whole lap, which is driven from now on.
  LapPlan whole(const std::vector<WindowNode>& lap);
  /// Goes a share of the way to the plan of a window's first three quarters, from its node `from` (0 or 1) on, which
  /// are solved for friction `mu`.
  void follow(const LapWindow& window, const std::vector<WindowNode>& lap, std::size_t from, double share, double mu,
              LapPlan& plan);
  /// Sets the speeds of the window's nodes: lower ones where their plan is for more friction than `mu`.
  void set_speeds(const LapWindow& window, double mu, LapPlan& plan) const;
  /// Lowers the speed of a node where there is only this share of the friction that there was.
  void slow_down(std::size_t node, double share);

 private:
  LapPlan::Node node_of(const std::vector<WindowNode>& lap, std::size_t i) const;
  LapPlan::Node first_node_of(const std::vector<WindowNode>& lap, std::size_t i) const;

  const LapSetup* setup_;
  std::vector<double> mu_;  // friction that each node's plan is for
  std::vector<double> v_;   // its speed for that friction [m/s]
};

}  // namespace gripline::time_optimal
