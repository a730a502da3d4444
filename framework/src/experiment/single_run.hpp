// One run of a race, one stack and one seed: in this process, or as the body of a process of its own.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <string>

#include "experiment/run_folder.hpp"
#include "experiment/run_key.hpp"
#include "plugin/guard.hpp"
#include "race/metrics.hpp"

namespace gripline {

/// Progress of a run, in memory that its process writes and the waiting process reads.
struct RunProgress {
  std::atomic<double> fraction{0.0};    // of the race
  std::atomic<double> preparing{-1.0};  // share done of what a plugin computes before the first step; negative: nothing
  SharedText what;                      // name of that computation
  LastCall last;
  std::atomic<bool> kept{false};          // the results are in their folder: a failure after that changes nothing
  std::atomic<bool> disk_refused{false};  // what the run could not write (DiskError)
};

/// Exit code of a run's process that could not even write a summary.
inline constexpr int run_lost = 4;

/// Races in this process, its files under OUT/<stack>/<seed>/. `progress` may be null. A plugin's failure is
/// in the summary; throws std::runtime_error when files cannot be written.
RunSummary run_here(const RaceSpec& race, const RunId& id, const std::string& key, const std::filesystem::path& out,
                    RunProgress* progress, MachineUse use = MachineUse::shared);

/// What a run's process is given.
struct ProcessSetup {
  std::size_t memory_mb = 0;  // of data that it may have; 0: no limit
  MachineUse use = MachineUse::shared;
  pid_t parent = 0;  // it ends when its parent does
};

/// run_here() as the body of a process that was forked from its parent: its output goes to log.txt in the run's folder.
[[noreturn]] void run_as_process(const RaceSpec& race, const RunId& id, const std::string& key,
                                 const std::filesystem::path& out, const ProcessSetup& setup, RunProgress* progress);

/// " (plugins of this run: ...)": for failures that cannot be assigned to one of them, such as a closed file.
std::string plugins_of(const RaceSpec& race, const RunId& id);

}  // namespace gripline
