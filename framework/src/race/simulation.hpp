// Algorithm 1 of the paper: one world, one stack, one rate, a fixed order.
#pragma once

#include <vector>

#include "race/metrics.hpp"
#include "race/recorder.hpp"
#include "race/stack.hpp"
#include "world/world.hpp"

namespace gripline {

/// Somebody who looks at every step before the stack learns from it: validation.
class StepObserver {
 public:
  virtual ~StepObserver() = default;
  /// The true car went from `before` under u to world.state().
  virtual void on_step(const State& before, const Place& at, const Input& u, const World& world, Stack& stack) = 0;
};

class Simulation {
 public:
  /// All must outlive the simulation.
  Simulation(World& world, Stack& stack, Recorder& recorder, Metrics& metrics);

  /// Races until the world ends it. Every row up to the end is written whatever happens; never throws for a plugin's
  /// fault.
  RunSummary run();
  /// May be null; must outlive the run.
  void observe_with(StepObserver* observer) { observer_ = observer; }
  /// `told` is called after every step with the share of the race that is done; may be null.
  void on_progress(void (*told)(void*, double), void* context) { told_ = told, told_context_ = context; }

 private:
  void start();
  void step();
  Sample sample_of(const Observation& before);
  void decide();
  bool over(RunSummary& summary) const;
  void tell_progress() const;

  World& world_;
  Stack& stack_;
  Recorder& recorder_;
  Metrics& metrics_;
  Observation now_;
  Input u_;
  std::vector<RefPoint> horizon_;
  Command command_;
  StepTiming timing_;
  void (*told_)(void*, double) = nullptr;
  void* told_context_ = nullptr;
  StepObserver* observer_ = nullptr;
};

}  // namespace gripline
