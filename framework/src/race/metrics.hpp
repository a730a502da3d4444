// Metrics of a run (framework/doc/metrics.md): lap times, deviation, time outside, error of the friction estimate.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "race/stack.hpp"
#include "world/world.hpp"

namespace gripline {

enum class Status { finished, crashed, stuck, timeout, plugin_error, error };
std::string_view status_name(Status status);

struct RunSummary {
  std::string stack;
  std::uint64_t seed = 1;
  Status status = Status::error;
  std::string message;  // why it ended when it did not finish, and what makes even a finished run doubtful
  bool needs_truth = false;
  std::vector<double> laps, lap_mean_factors;  // [s], [-]
  std::optional<double> mean_deviation_m;      // empty if the planner follows no line
  std::optional<double> hilly_deviation_m;     // mean_deviation_m where the road is steeper than 3 %; empty if none
  double violation_s = 0, violation_body_s = 0;
  std::optional<double> violation_after_adapt_s, violation_body_after_adapt_s;
  /// Root mean square of the estimated total mu against mu_true over every step at which the stack trusts what it
  /// learned; against mu_visited from two lap lengths of way after that moment on. Bias: estimated minus true, as
  /// mu_rmse.
  std::optional<double> mu_rmse, mu_visited_rmse, mu_bias;
  double plan_latency_s = 0;  // SpeedPlanner::latency
  std::int64_t solver_failures = 0, steps = 0;
  double simulated_s = 0;

  /// One before the first step, one after every step; a plugin that broke may have left out the last.
  std::int64_t solves() const { return steps + 1; }
  /// Whether more than one solve in ten failed: much of the run was driven by the controller's fallback.
  bool many_failed_solves() const { return 10 * solver_failures > solves(); }
};

/// Distance from a point to a closed line given by samples, measured to its chords.
double distance_to_line(std::span<const LinePoint> line, double x, double y);

class Metrics {
 public:
  Metrics(const World& world, const StackSpec& stack, std::uint64_t seed);
  /// Before the first step, whose command is decided then.
  void start(bool solved);
  /// After every control step of the world, at the state it led to and before the stack is asked: a stack that breaks
  /// there has driven the step, and the lap that ended in it.
  void step();
  /// After step(), what the stack decided there.
  void decision(const StackBelief& belief, std::span<const LinePoint> line, bool solved, double plan_latency);
  double mu_true() const;
  RunSummary summary(Status status, std::string message) const;

 private:
  struct Mean {
    double sum = 0;
    std::int64_t count = 0;
    void add(double value) { sum += value, ++count; }
    double mean() const { return count > 0 ? sum / static_cast<double>(count) : 0.0; }
  };
  /// Control steps that ended with the centre of gravity, or a corner of the car, outside the road.
  struct StepsOutside {
    std::int64_t centre = 0, body = 0;
    void add(const World& world) { centre += world.outside(), body += world.body_outside(); }
  };
  void visit_slips();
  void visit_slip(Axle axle);
  void lap(double ended);
  void add_friction_error(const Belief& belief);

  const World& world_;
  RunSummary summary_;
  StepsOutside outside_;
  std::optional<StepsOutside> outside_after_adapt_;  // from the moment on that the estimate is trusted
  double lap_began_ = 0;
  double factor_of_step_;  // friction factor of the step that is driven next; the world shows the one that begins
  Mean factor_, deviation_, hilly_deviation_, mu_square_, visited_square_, bias_;
  double largest_slip_[2] = {0, 0};
  double largest_force_[2] = {0, 0};     // over the slips seen, at factor 1 [N]
  double car_weight_ = 0;                // m g
  std::optional<double> trusted_since_;  // laps driven
};

}  // namespace gripline
