// What a sweep knows of each kind of experiment: where it keeps rows and seed, how it is read, how its runs are made,
// and what numbers they leave.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "config/node.hpp"
#include "experiment/experiment.hpp"
#include "plugin/registry.hpp"
#include "sweep/store.hpp"
#include "util/file_hashes.hpp"

namespace gripline::sweep {

/// A kind of experiment: a row of the table in kinds.cpp.
struct SweptKind {
  const char* name;    // as "kind" says it
  const char* rows;    // member whose members are rows: "stacks", "cases", "estimators"; null: one row without a name
  const char* seeds;   // "seeds" {first, count}, "seed", or null: it draws nothing
  bool merges_base;    // rows are merge patches on "base"
  bool tries_effects;  // all effects that are found, whatever its experiment names
  /// Reads an experiment whole and runs nothing. Throws InputError, PluginError.
  void (*check)(const std::filesystem::path& file, const Node& tree, const Registry& registry);
  /// Runs a tree of one row, its files below `scratch`. Null: a race, read once a setting (RaceRuns).
  Values (*run)(const std::filesystem::path& file, const Node& tree, const Registry& registry,
                const std::filesystem::path& scratch);
};
/// Throws InputError at the tree's "kind".
const SweptKind& kind_of(const Node& tree);
/// Throws InputError when there is none of that name.
const SweptKind& kind_named(std::string_view name);

/// Limits of a run.
struct RunLimits {
  double timeout_s = 0;       // 0: from the world of a race, else an hour without a word
  std::size_t memory_mb = 0;  // 0: none
};

/// What became of a run that was tried.
struct Attempt {
  Record record;                // without its key
  std::filesystem::path files;  // what it wrote; may be absent
  bool interrupted = false;     // a signal to this program ended it: there is nothing to keep
  bool cut_off = false;         // killed from outside, or the disk refused: another try may do better
};

/// The race of one setting, read once; runs are asked for by row and seed.
class RaceRuns {
 public:
  RaceRuns(const std::filesystem::path& file, Node tree, const Registry& registry);
  /// Raced in a process of its own below `scratch` (race_runner.hpp).
  Attempt run(const std::string& row, std::uint64_t seed, const std::filesystem::path& scratch, const RunLimits& limits,
              FileHashes& hashes) const;

 private:
  RaceSpec race_;
};

/// A run of another kind: `tree` has one row. In a process of its own, its files below `scratch`.
Attempt run_other(const std::filesystem::path& file, const SweptKind& kind, const Node& tree, const Registry& registry,
                  const std::filesystem::path& scratch, const RunLimits& limits);

}  // namespace gripline::sweep
