// Runs of a race as processes: one stack and one seed each, so that a crash costs one run.
#pragma once

#include <atomic>
#include <filesystem>
#include <map>
#include <vector>

#include "experiment/experiment.hpp"
#include "experiment/run_result.hpp"
#include "plugin/guard.hpp"

namespace gripline {

class FileHashes;

struct RunnerOptions {
  std::filesystem::path out;
  int jobs = 1;
  bool show_progress = true;
  double timeout_s = 0;          ///< wall clock that one run may take; 0: default_timeout() of its world
  std::size_t memory_mb = 0;     ///< of data that one run may have; 0: no limit
  FileHashes* hashes = nullptr;  ///< for many calls: what is known of files stays known
};

/// Wall clock after which a run surely hangs [s]: generous, from the longest race that the world allows.
double default_timeout(const WorldSpec& world);

struct RunId {
  std::string stack;
  std::uint64_t seed;
};

/// SHA-256 of files, each read once.
class FileHashes {
 public:
  const std::string& of(const std::filesystem::path& file);

 private:
  std::map<std::filesystem::path, std::string> known_;
};

/// Names a run by its inputs: the expanded JSON and the files it names, the libraries of the plugins it uses, the
/// program that runs.
std::string run_key(const RaceSpec& race, const RunId& id, FileHashes& hashes);

/// How far a run is: written by the process that races, read by the one that waits.
struct RunProgress {
  std::atomic<double> fraction{0.0};    // of the race
  std::atomic<double> preparing{-1.0};  // of what a plugin computes before the first step; negative: nothing
  SharedText what;                      // it computes
  LastCall last;
  std::atomic<bool> kept{false};  // the results are in their place: whatever happens now spoils nothing
};

/// One run in this process, its files under OUT/<stack>/<seed>/. `progress` may be null.
RunSummary run_here(const RaceSpec& race, const RunId& id, const std::string& key, const std::filesystem::path& out,
                    RunProgress* progress);

/// Runs what is not yet finished, at most `jobs` at a time, each in its own process. Where nothing in the world is drawn
/// from the seed, and the first two seeds asked for of a stack drove the same run to the last bit, the others would do
/// so too: they are not driven, and their summaries say whose run it is (RunResult::driven_as). On an interrupt (Ctrl-C) the
/// running ones are stopped and `interrupted` is set. Results are in the order asked for.
struct RunnerOutcome {
  std::vector<RunResult> runs;
  int kept = 0;
  int replaced = 0;  ///< finished runs of other inputs, plugins or versions whose place was taken
  bool interrupted = false;
  std::vector<std::string> notes;  ///< what the user should know: "elm, seed 1: steps.csv was changed ..."
};
/// The runs of this race that are finished or failed in OUT, by whichever call: stacks in the order of the experiment,
/// seeds ascending. Results of other inputs, plugins or versions of the program are left out.
std::vector<RunResult> results_in(const RaceSpec& race, const std::filesystem::path& out);

RunnerOutcome run_all(const RaceSpec& race, const std::vector<RunId>& ids, const RunnerOptions& options);

}  // namespace gripline
