// Engine `slurm`: array jobs, and a merge job after them, by Slurm's own commands (sbatch, squeue, scancel).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sweep/engine.hpp"

namespace gripline::sweep {

struct SlurmOptions {
  std::filesystem::path program;  // that jobs call
  std::string partition, time, mem;
  std::vector<std::string> extra;  // of sbatch
  int at_once = 0;                 // tasks at the same time; 0: as many as there is room for
  std::filesystem::path scratch;   // for files of running runs; empty: in OUT
};

/// Every array has at most the cluster's MaxArraySize tasks. The merge job runs after all of them whatever became of
/// them (afterany), and is one of the submission's jobs. A task that ends with 75 is requeued where the cluster's
/// RequeueExit says so; elsewhere it is missing until the sweep is resumed.
class SlurmEngine final : public Engine {
 public:
  explicit SlurmEngine(SlurmOptions options) : options_(std::move(options)) {}
  std::string plan(const Batch& batch) const override;
  void submit(const Batch& batch, Submission& submission, const std::function<void()>& keep) override;
  EngineState status(const Submission& submission);
  /// Ends what waits and what runs. Finished records stay.
  void cancel(const Submission& submission);

 private:
  std::vector<std::string> common_arguments(const Batch& batch) const;
  SlurmOptions options_;
};

}  // namespace gripline::sweep
