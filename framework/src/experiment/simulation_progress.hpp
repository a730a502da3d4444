// The progress of work that consists of several simulations.
#pragma once

#include <string>

#include "race/simulation.hpp"
#include "util/progress.hpp"

namespace gripline {

/// One of `count` parts of the work, as it is reported to the callback. Must outlive the simulations that it follows.
struct SimulationProgress {
  const ProgressCallback& callback;  // may be empty
  std::size_t index, count;
  std::string what;

  /// The callback is called after every step of the simulation.
  void follow(Simulation& simulation) {
    if (!callback) return;
    simulation.on_progress([this](double share) { callback(static_cast<double>(index) + share, count, what); });
  }
};

}  // namespace gripline
