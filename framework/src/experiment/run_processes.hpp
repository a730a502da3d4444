// The processes of runs: started, watched, stopped, and what they leave behind when they fail.
#pragma once

#include <signal.h>  // NOLINT(modernize-deprecated-headers): struct sigaction is POSIX
#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiment/single_run.hpp"
#include "util/child_process.hpp"
#include "util/family_mark.hpp"
#include "util/shared_array.hpp"

namespace gripline {

/// Notices Ctrl-Z (SIGTSTP) for as long as it lives. The processes of runs are not in the terminal's process group, so
/// that the signal does not stop them.
class PauseWatch {
 public:
  PauseWatch();
  ~PauseWatch();
  PauseWatch(const PauseWatch&) = delete;
  PauseWatch& operator=(const PauseWatch&) = delete;
  /// Whether Ctrl-Z came since the last call.
  static bool take();

 private:
  struct sigaction before_ {};
};

/// Makes this process the one that collects the processes of runs and what those leave behind, whatever signal handling
/// it was started with: SIGCHLD is handled as usual, and orphans are handed to this process. Orphans that other children
/// of this process leave meanwhile come to it as well; nobody ends or collects those.
class ParentOfRuns {
 public:
  ParentOfRuns();
  ~ParentOfRuns();
  ParentOfRuns(const ParentOfRuns&) = delete;
  ParentOfRuns& operator=(const ParentOfRuns&) = delete;

 private:
  UsualChildSignal statuses_are_kept_;
  int was_subreaper_ = 0;
};

struct ProcessLimits {
  double timeout_s = 0;        ///< wall clock that one run may take; 0: no limit
  std::size_t memory_mb = 0;   ///< of data that one run may have; 0: no limit
  bool one_at_a_time = false;  ///< the caller starts none before the last one ended
};

/// Runs in processes of their own, ended with all that they started, daemons too (FamilyMark); other children of this
/// process are left alone. Each run has a slot, a number below the count given to the constructor. The race must outlive
/// this object.
class RunProcesses {
 public:
  RunProcesses(const RaceSpec& race, std::filesystem::path out, const ProcessLimits& limits, std::size_t count);
  /// Stops what still runs.
  ~RunProcesses();
  RunProcesses(const RunProcesses&) = delete;
  RunProcesses& operator=(const RunProcesses&) = delete;
  std::size_t running() const { return children_.size(); }
  bool is_running(std::size_t slot) const;
  /// Counts as done without a start.
  void skip(std::size_t slot);
  /// Sum over all slots of the share of the race that is done.
  double fractions() const;
  /// What runs now, for the progress line: "elm seed 3, gp seed 1 (laps 40 %)".
  std::string names() const;
  /// What the user should know of runs that ended: "elm, seed 1 is complete; afterwards its process ...".
  const std::vector<std::string>& notes() const { return notes_; }
  /// Runs that ended for no reason of their own: killed from outside, or the disk refused.
  const std::vector<RunId>& cut_off() const { return cut_off_; }

  /// Throws std::runtime_error when there is no process to be had.
  void start(const RunId& id, const std::string& key, std::size_t slot);
  /// Collects every process that ended, keeps what is left of failed ones, and ends those that take too long.
  void reap();
  /// Returns when a run ends or a signal arrives, after 100 ms at the latest.
  void wait() const;
  /// Stops this process and all runs until it is continued (SIGCONT); the time in between counts for no limit.
  void pause();
  /// Ends all runs and removes their partial results.
  void stop();

 private:
  using Clock = std::chrono::steady_clock;
  struct Job {
    RunId id;
    std::string key;
    std::size_t slot;
    Clock::time_point begun;
    std::optional<Clock::time_point> kept;  // when its results were found in their folder
    std::string ended_because;              // why it was ended from here; empty: it ended by itself
  };

  static std::string name_of(const Job& job);
  void settle(const Job& job, int status);
  void watch(pid_t pid, Job& job);
  void end_orphans();

  const RaceSpec& race_;
  std::filesystem::path out_;
  ProcessLimits limits_;
  SharedArray<RunProgress> progress_;
  FamilyMark mark_;  // of the runs and what they start
  std::map<pid_t, Job> children_;
  std::vector<std::string> notes_;
  std::vector<RunId> cut_off_;
};

}  // namespace gripline
