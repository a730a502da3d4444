// All runs of a race, each in a process of its own, so that a crash costs one run.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "experiment/run_key.hpp"
#include "experiment/run_result.hpp"

namespace gripline {

struct RunnerOptions {
  std::filesystem::path out;
  int jobs = 1;
  bool show_progress = true;
  double timeout_s = 0;          ///< wall clock that one run may take; 0: default_timeout() of its world
  std::size_t memory_mb = 0;     ///< of data that one run may have; 0: no limit
  FileHashes* hashes = nullptr;  ///< shared by many calls, so that each file is read once; null: this call's own
};

/// Wall clock after which a run certainly hangs [s]: generous, from the longest race that the world allows.
double default_timeout(const WorldSpec& world);

struct RunnerOutcome {
  std::vector<RunResult> runs;  ///< in the order asked for
  int kept = 0;                 ///< runs that were finished before this call
  int replaced = 0;             ///< finished runs of other inputs, plugins or versions, which were overwritten
  bool interrupted = false;
  std::vector<RunId> cut_off;      ///< broken runs that another try may finish: killed from outside, the disk refused
  std::vector<std::string> notes;  ///< what the user should know: "elm, seed 1: steps.csv was changed ..."
};

/// Runs what is not yet finished, at most `jobs` at a time, each in its own process. Where nothing in the world depends
/// on the seed, and the first two seeds asked for of a stack drove the same run to the last bit, the others would too:
/// they are not driven, and their summaries name the seed whose run it is (RunResult::driven_as). On an interrupt
/// (Ctrl-C) the running ones are stopped and `interrupted` is set.
RunnerOutcome run_all(const RaceSpec& race, const std::vector<RunId>& ids, const RunnerOptions& options);

/// The runs of this race that are finished or failed in OUT, by whichever call: stacks in the order of the experiment,
/// seeds ascending. Results of other inputs, plugins or versions of the program are left out.
std::vector<RunResult> results_in(const RaceSpec& race, const std::filesystem::path& out);

}  // namespace gripline
