// A lap as it is followed: offset from the base line, speed and sideslip at the nodes, and the line that results.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "planners/time_optimal/lap_setup.hpp"

namespace gripline::time_optimal {

/// What is kept of a solution: at each node the offset n [m], its slope dn/ds, the speed along the path [m/s], the
/// sideslip angle [rad] and the path's curvature [1/m]. Plans of one setup are interpolated linearly: offsets stay
/// within the edges.
struct LapPlan {
  struct Node {
    double n = 0, slope = 0, v = 0, beta = 0, kappa = 0;
  };
  std::vector<Node> nodes;
  double time = 0;  // [s]
};
LapPlan make_plan(const LapSetup& setup, const LapSolution& solution);
/// Node i of it but for the curvature, from the lap's variables at the node before, there and at the node after.
LapPlan::Node plan_node(const LapSetup& setup, std::size_t i, const std::array<double, lap_variables>& before,
                        const std::array<double, lap_variables>& here, const std::array<double, lap_variables>& after);
/// Sets the path's curvature at `count` nodes from `first` on (indices wrap), given offsets and slopes there and at the
/// nodes before and after them: the change of heading from a node before to the one after, over the way between.
void set_curvatures(const LapSetup& setup, std::size_t first, std::size_t count, LapPlan& plan);
/// out = (1 - weight) a + weight b. `out` may be a or b.
void interpolate(const LapPlan& a, const LapPlan& b, double weight, LapPlan& out);

/// Where the plan leads at a station of the base line.
struct PlanPoint {
  double x = 0, y = 0, yaw = 0;  // of the path
  double v = 0, beta = 0, kappa = 0;
  double stretch = 1;  // metres of path per metre of base line
};

/// A plan that is driven. All queries are by station of the base line; nothing is allocated after construction.
class PlanFollower {
 public:
  explicit PlanFollower(const LapSetup& setup);

  void set(const LapPlan& plan);
  /// As set(plan), where only nodes first .. first + count - 1 (indices wrap) have changed.
  void set(const LapPlan& plan, std::size_t first, std::size_t count);
  PlanPoint at(double s) const;
  /// Station of the point of the path nearest to a car at (x, y) that faces `yaw`, continuing from the last call.
  double locate(double x, double y, double yaw);
  /// The path as a closed line of samples, for reports.
  std::span<const LinePoint> samples() const { return samples_; }

 private:
  struct Offset {
    double n = 0, slope = 0;
  };
  Offset offset(std::size_t k, double share) const;
  double refine(double s, double x, double y) const;
  double beside_plan(double near, double x, double y) const;
  void place_interval(std::size_t k);
  void place_sample(std::size_t i);
  void measure_samples(std::size_t from);

  static constexpr std::size_t samples_per_interval = 4;
  const LapSetup* setup_;
  const planning::ClosedLine* base_;
  const LapNodes* nodes_;
  LapPlan plan_;
  struct Heading {
    double sine = 0, cosine = 1;
  };
  std::vector<LinePoint> base_samples_, samples_;
  std::vector<Heading> base_heading_;  // of the base line at its samples
  double hint_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace gripline::time_optimal
