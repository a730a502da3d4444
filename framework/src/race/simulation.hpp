// Algorithm 1 of the paper: one world, one stack, one rate, a fixed order.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "race/metrics.hpp"
#include "race/race_end.hpp"
#include "race/recorder.hpp"
#include "race/stack.hpp"
#include "world/world.hpp"

namespace gripline {

/// Is shown every step before the stack learns from it.
class StepObserver {
 public:
  virtual ~StepObserver() = default;
  /// The true car went from `before` under u to world.state().
  virtual void on_step(const State& before, const Place& at, const Input& u, const World& world, Stack& stack) = 0;
};

class Simulation {
 public:
  /// All must outlive the simulation; without a recorder no rows are written. Throws PluginFailure when the controller
  /// wants a horizon that cannot be.
  Simulation(World& world, Stack& stack, Metrics& metrics, Recorder* recorder);

  /// Races until the world ends it. Every row up to the end is written in any case. A plugin's failure is in the
  /// summary's status and message, never thrown.
  RunSummary run();
  /// May be null; must outlive the run.
  void observe_with(StepObserver* observer) { observer_ = observer; }
  /// Is called after every step with the share of the race that is done, in [0, 1]; may be empty.
  void on_progress(std::function<void(double share)> callback) { progress_ = std::move(callback); }

  /// The parts of run(), for callers that stop at every step: start() once, then step() any number of times.
  /// Both throw PluginFailure.
  void start();
  void step();
  /// Lines 5-7 are left out from now on: the estimator stays as it is.
  void stop_learning() { learns_ = false; }
  /// The instant reached, and what was decided there.
  const Observation& now() const { return now_; }
  /// The observation of the instant reached that planner and controller act on: filtered where the stack has a filter.
  const Observation& acted_on() const { return acted_on_; }
  std::span<const RefPoint> horizon() const { return horizon_; }
  const Command& command() const { return command_; }
  /// Line 4 of the last step, and the CPU times of its update, plan and solve.
  const Sample& sample() const { return sample_; }
  const StepTiming& timing() const { return timing_; }

 private:
  void filter_reading();
  void decide();
  bool over(RunSummary& summary) const;
  std::string why(Status ended) const;
  void tell_progress() const;

  World& world_;
  Stack& stack_;
  Metrics& metrics_;
  Recorder* recorder_;
  RaceEnd end_;
  Observation now_;
  std::optional<StateFilter> filter_;
  Observation acted_on_;
  CorrectedModel* model_ = nullptr;  // believed at the last decision
  Input u_;
  std::vector<RefPoint> horizon_;
  Command command_;
  StepTiming timing_;
  Sample sample_;
  bool learns_ = true;
  std::function<void(double)> progress_;
  StepObserver* observer_ = nullptr;
};

}  // namespace gripline
