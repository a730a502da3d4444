// Does the runs of one task, for workers of this machine and for jobs of a cluster.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "sweep/engine.hpp"
#include "sweep/keys.hpp"
#include "sweep/kinds.hpp"
#include "sweep/store.hpp"
#include "sweep/sweep.hpp"

namespace gripline::sweep {

/// Makes one run.
using Runner = std::function<Attempt(const RunAt& run)>;

/// A sweep opened for work. Expensive to make (experiments are read, libraries hashed), cheap to use.
class Worker {
 public:
  /// `sweep` and `registry` must outlive it. Files of runs go below `scratch`, which must be this worker's own.
  Worker(const Sweep& sweep, const Registry& registry, std::filesystem::path out, std::filesystem::path scratch);
  /// Does the runs of a task that have no record yet, in order, and records each as it ends; broken ones are repeated
  /// where the batch says so. A run whose inputs are no longer those of the manifest, or were changed meanwhile, is
  /// refused (TaskExit task_refused); of one that was cut off only the reason is kept.
  int run(const Batch& batch, std::size_t task, const std::function<void()>& done);
  /// In place of racing (tests).
  void run_with(Runner runner) { runner_ = std::move(runner); }
  /// Makes one run and records nothing: what a run costs.
  Record try_run(const RunAt& run);

 private:
  Attempt make(const RunAt& run);
  int keep(Attempt attempt, std::size_t index, const std::string& key) const;
  void settle_files(const std::filesystem::path& folder, const std::string& key) const;

  const Sweep& sweep_;
  const Registry& registry_;
  std::filesystem::path out_, scratch_;
  Keys keys_;
  KeyFile planned_;
  Store store_;
  Runner runner_;
  std::unique_ptr<RaceRuns> races_;  // of the setting at hand
  std::size_t part_ = 0, setting_ = 0;
};

}  // namespace gripline::sweep
