// The whole lap that windows are solved of, as the iterate of its program, and how it is carried over to less friction.
//
// But for resistances and limits of drive and brakes, a car's motion at a share of the friction is the same, along the
// same way with the same slips, at speeds that are lower by the share's square root (at_share()). How much of an
// iterate goes with its states depends on what it is for:
//   slowed(), reset()  states alone: ends of a window, and a start for Newton steps
//   slow_down()        and the acceleration that was planned: what a window finds where it comes to new nodes
//   scale()            and all inputs and multipliers: a window that goes on as good as it was
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "planners/time_optimal/lap_setup.hpp"
#include "planners/time_optimal/lap_window.hpp"
#include "planners/time_optimal/window_solver.hpp"

namespace gripline::time_optimal {

class KeptLap {
 public:
  using States = std::array<double, lap_variables>;

  /// The base line, driven at nearly the speed that these tyres allow on it.
  KeptLap(const LapSetup& setup, const AxleTyres& tyres);

  /// Which inputs go with the states.
  enum class Inputs { none, acceleration, all };
  /// The same motion at this share of its friction, its other inputs as they are.
  static States at_share(States z, double share, Inputs inputs = Inputs::none);

  std::size_t size() const { return nodes_.size(); }
  std::vector<WindowNode>& nodes() { return nodes_; }
  const std::vector<WindowNode>& nodes() const { return nodes_; }
  const States& at(std::size_t node) const { return nodes_[node].z; }
  /// The state at a node, slowed down where it was solved for more friction than `mu`.
  States slowed(std::size_t node, double mu) const;

  /// A node was solved for this friction.
  void set_solved_for(std::size_t node, double mu) { solved_for_[node] = mu; }
  /// A node with clearly more friction than `mu` is kept slowed down from now on.
  void slow_down(std::size_t node, double mu);
  /// A node of a window at a share of the friction that the window was for, which is `mu` now: with its multipliers, so
  /// that the window stays as good as it was.
  void scale(std::size_t node, double share, double mu);

  /// What is kept now is what nodes begin again from.
  void remember();
  const States& remembered(std::size_t node) const { return first_lap_[node]; }
  double remembered_for() const { return first_mu_; }  // friction
  /// A node as it is remembered, slowed down to this friction, without slacks and multipliers.
  void reset(std::size_t node, double mu);

 private:
  std::vector<WindowNode> nodes_;
  std::vector<double> solved_for_;  // friction that each node was last solved for
  std::vector<States> first_lap_;
  double first_mu_;
};

}  // namespace gripline::time_optimal
