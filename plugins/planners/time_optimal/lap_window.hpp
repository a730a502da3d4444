// The part of a lap that is solved ahead of the car: which nodes it has, and how it moves on as the car does.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "planners/time_optimal/lap_setup.hpp"
#include "planners/time_optimal/window_solver.hpp"

namespace gripline::time_optimal {

/// Nodes first() .. first() + count() of a lap, whose indices wrap: from a little behind the car to `ahead` seconds
/// ahead of it, at the speeds of the lap that is kept.
class LapWindow {
 public:
  using Nodes = std::vector<WindowNode>;  // of the whole lap

  /// `most`: intervals that a window has at most; `ahead`: how far it reaches ahead of the car [s].
  LapWindow(const LapSetup& setup, std::size_t most, double ahead);

  std::size_t first() const { return first_; }
  /// Intervals; 0 before it is placed.
  std::size_t count() const { return count_; }
  /// The intervals, from the first on, that do not depend on how the window is made to end.
  std::size_t near_count() const { return WindowSolver::near_part(count_); }
  /// The node that is `k` after the first.
  std::size_t node(std::size_t k) const { return (first_ + k) % size(); }
  std::size_t last() const { return node(count_); }
  /// How many nodes after the first a node is.
  std::size_t nodes_to(std::size_t node) const { return (node + size() - first_) % size(); }
  /// Whether a window that begins at a node shares intervals with this one.
  bool reaches(std::size_t node) const { return nodes_to(node) < count_; }

  /// Where it would begin for a car at this station of the base line.
  std::size_t first_behind(double station, const Nodes& lap) const;
  /// Whether the window may stay where it is although the car asks for `wanted` as its first node: for a moment.
  bool may_stay(std::size_t wanted, const Nodes& lap) const;
  /// Whether a node is a little behind the first one.
  bool is_just_behind(std::size_t node) const { return (first_ + size() - node) % size() < just_behind(); }
  /// Places the window from node `first` on, as long as it has to be. Returns how many intervals from there on were
  /// part of it before; that may be more than it has now.
  std::size_t place(std::size_t first, const Nodes& lap);

 private:
  std::size_t size() const { return setup_->nodes().s.size(); }
  /// So many nodes at most lie a little behind one: an eighth of the lap. Beyond it another part of the lap is meant.
  std::size_t just_behind() const { return size() / 8; }
  double rough_time_over(std::size_t node, const Nodes& lap) const;
  std::size_t length_from(std::size_t first, const Nodes& lap) const;

  const LapSetup* setup_;
  std::size_t most_;
  double ahead_;  // [s]
  std::size_t first_ = 0, count_ = 0;
};

/// The node behind a car that is beside this station of the base line.
std::size_t node_behind(const LapSetup& setup, const State& car, double station);
/// The variables of a lap with which a car passed the node behind it: back along an arc, at the speeds that it has now.
std::array<double, lap_variables> passed_with(const LapSetup& setup, const State& car, std::size_t node);

}  // namespace gripline::time_optimal
