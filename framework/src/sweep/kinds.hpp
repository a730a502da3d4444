// How a run of each kind of experiment is made, and what numbers it leaves.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/node.hpp"
#include "experiment/run_key.hpp"
#include "plugin/registry.hpp"
#include "sweep/store.hpp"

namespace gripline::sweep {

/// Reads an experiment of any kind whole and runs nothing. Throws InputError, PluginError.
void check_experiment(const std::filesystem::path& file, Node tree, const Registry& registry);

/// Limits and places of runs.
struct RunLimits {
  double timeout_s = 0;       // 0: from the world of a race, else an hour without a word
  std::size_t memory_mb = 0;  // 0: none
};

/// The race of one setting, read once; runs are asked for by row and seed.
class RaceRuns {
 public:
  RaceRuns(const std::filesystem::path& file, Node tree, const Registry& registry);
  /// Raced in a process of its own below `scratch` (race_runner.hpp); no key is filled in. `interrupted` is set when a
  /// signal ended it: then there is nothing to keep.
  Record run(const std::string& row, std::uint64_t seed, const std::filesystem::path& scratch, const RunLimits& limits,
             FileHashes& hashes, bool& interrupted) const;

 private:
  RaceSpec race_;
};

/// A run of another kind: `tree` has one row. In a process of its own, its files below `scratch`.
Record run_other(const std::filesystem::path& file, const std::string& kind, const Node& tree, const Registry& registry,
                 const std::filesystem::path& scratch, const RunLimits& limits);

/// Whether a broken run may do better elsewhere or later: it was killed from outside.
bool may_be_retried(const Record& record);

}  // namespace gripline::sweep
