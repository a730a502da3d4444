// What drives the car: nominal model, estimator, planner, controller, and from when on the model is corrected
// and plans rest on the estimate.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "car/vehicle.hpp"
#include "race/sample.hpp"
#include "race/state_filter.hpp"

namespace gripline {

struct StackSpec {
  std::string name;
  std::optional<Car> car;  // the car as the stack states it, where that is not the world's
  VehicleSpec model;
  PluginSpec estimator;  // may be empty
  PluginSpec planner, controller;
  double adapt_after = 0.0;  // [s] from then on the learned correction is part of the model
  // [s] Until then planners are given mu_init all the same. One that is given no belief has a parameter for that.
  double careful_until = 0.0;
  double mu_init = 1.0;
  std::optional<StateFilterSpec> state_filter;  // planner and controller act on the readings where there is none
  Origin state_filter_at;                       // where it is written
  bool needs_truth() const;
};
StackSpec read_stack(const std::string& name, const Node& node, const Registry& registry, const CarFile& car,
                     Errors& errors);
/// Refuses sensors that the stack's filter would take wrongly: those with delays.
void check_sensors(const StackSpec& stack, const SensorSpec& sensors, Errors& errors);

/// The stack's present model and friction estimate: Algorithm 1, lines 8-13.
struct StackBelief {
  CorrectedModel* model;  // f_nom until adapt_after, f_corr from then on
  Belief mu;
  const TyreCurve* learned;  // null until mu is trusted
};

/// Is told what a plugin computes before the first step and the share of it that is done, 0 to 1.
using PreparingCallback = std::function<void(std::string_view what, double share)>;

/// What a stack is given of the world it drives in. `truth` reaches only plugins that declare they need it.
struct StackContext {
  Car car;
  double dt = 0.02;
  Hold hold = Hold::zoh;
  std::uint64_t seed = 1;
  const Course* course = nullptr;
  const Truth* truth = nullptr;
  std::string cache_dir;             // empty: nothing is kept; else each library gets a folder of its own in it
  PreparingCallback on_preparing{};  // may be empty
};

/// What the plugins of a stack are given: of its car by the stack, of all else by the world. The stack adds the
/// callback, and for each of them nominal model, truth and cache.
PluginContext plugin_context(const StackSpec& spec, const StackContext& world);

class Stack {
 public:
  /// The spec must outlive the stack. Throws PluginError when a plugin cannot be created.
  Stack(const StackSpec& spec, const StackContext& world, const Observation& start);
  // Its plugins keep pointers into it.
  Stack(const Stack&) = delete;
  Stack& operator=(const Stack&) = delete;

  /// What the step from `before` to `now` under u left unexplained (line 4); advances the memory of both models. Throws
  /// PluginFailure where the model or the estimator throws or predicts what is not finite.
  Sample sample(const Observation& before, const Input& u, const Observation& now);
  /// Updates the estimator, if there is one, with a step (Algorithm 1, lines 5-7).
  void learn(const Sample& sample);
  /// Throws PluginFailure where the estimator throws or believes in what is no friction.
  StackBelief belief(double t);
  SpeedPlanner& planner() { return *planner_; }
  Controller& controller() { return *controller_; }
  const TyreCurve* tyre_curve() const { return estimator_ ? estimator_->get() : nullptr; }
  const StackSpec& spec() const { return spec_; }
  /// The plugin whose derivatives are not finite at a state: the model, the first effect that makes them so, or
  /// else the estimator.
  std::string nonfinite_plugin(const Observation& now, const Input& u) const;

 private:
  StackBelief believed(double t);

  const StackSpec& spec_;
  std::array<std::string, 3> cache_dirs_;  // of estimator, planner, controller, which keep pointers into it
  PreparingCallback on_preparing_;         // plugins keep pointers to it too
  PluginContext context_;
  Vehicle vehicle_;
  CorrectedModel nominal_;
  std::optional<Instance<Estimator>> estimator_;
  CorrectedModel corrected_;
  Instance<SpeedPlanner> planner_;
  Instance<Controller> controller_;
};

}  // namespace gripline
