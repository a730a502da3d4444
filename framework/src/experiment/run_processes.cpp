#include "experiment/run_processes.hpp"

#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <iterator>
#include <utility>

#include "experiment/run_folder.hpp"
#include "util/child_process.hpp"
#include "util/disk.hpp"

namespace gripline {
namespace {

volatile std::sig_atomic_t pause_seen = 0;
void note_pause(int) { pause_seen = 1; }

}  // namespace

PauseWatch::PauseWatch() {
  pause_seen = 0;
  struct sigaction action {};
  action.sa_handler = note_pause;
  sigaction(SIGTSTP, nullptr, &before_);
  if (before_.sa_handler != SIG_IGN) sigaction(SIGTSTP, &action, nullptr);
}

PauseWatch::~PauseWatch() { sigaction(SIGTSTP, &before_, nullptr); }

bool PauseWatch::take() { return std::exchange(pause_seen, 0) != 0; }

ParentOfRuns::ParentOfRuns() {
  prctl(PR_GET_CHILD_SUBREAPER, &was_subreaper_);
  prctl(PR_SET_CHILD_SUBREAPER, 1);
}

ParentOfRuns::~ParentOfRuns() { prctl(PR_SET_CHILD_SUBREAPER, was_subreaper_); }

RunProcesses::RunProcesses(const RaceSpec& race, std::filesystem::path out, const ProcessLimits& limits,
                           std::size_t count)
    : race_(race), out_(std::move(out)), limits_(limits), progress_(count) {}

RunProcesses::~RunProcesses() { stop(); }

bool RunProcesses::is_running(std::size_t slot) const {
  return std::any_of(children_.begin(), children_.end(), [&](const auto& one) { return one.second.slot == slot; });
}

void RunProcesses::skip(std::size_t slot) { progress_[slot].fraction.store(1.0, std::memory_order_relaxed); }

double RunProcesses::fractions() const {
  double total = 0.0;
  for (std::size_t i = 0; i < progress_.size(); ++i) total += progress_[i].fraction.load(std::memory_order_relaxed);
  return total;
}

std::string RunProcesses::names() const {
  std::string text;
  for (const auto& [pid, job] : children_) {
    text += (text.empty() ? "" : ", ") + job.id.stack +
            (race_.seeds.size() > 1 ? " seed " + std::to_string(job.id.seed) : "");
    const RunProgress& now = progress_[job.slot];
    const double preparing = now.preparing.load(std::memory_order_relaxed);
    if (preparing >= 0 && now.fraction.load(std::memory_order_relaxed) <= 0)
      text += " (" + now.what.get() + " " + std::to_string(std::lround(100 * std::min(preparing, 1.0))) + " %)";
  }
  return text;
}

void RunProcesses::start(const RunId& id, const std::string& key, std::size_t slot) {
  disk().remove_all(partial_folder(out_, id));
  const pid_t parent = getpid(), pid = fork_process();
  if (pid == 0) {
    mark_.put_on();
    const MachineUse use = limits_.one_at_a_time ? MachineUse::exclusive : MachineUse::shared;
    run_as_process(race_, id, key, out_, {limits_.memory_mb, use, parent}, &progress_[slot]);
  }
  setpgid(pid, pid);
  children_[pid] = {id, key, slot, Clock::now(), {}, {}};
}

void RunProcesses::reap() {
  for (auto at = children_.begin(); at != children_.end();) {
    const auto next = std::next(at);
    if (const std::optional<int> status = collect_if_ended(at->first)) {
      const Job job = at->second;
      children_.erase(at);
      settle(job, *status);
    } else {
      watch(at->first, at->second);
    }
    at = next;
  }
  end_orphans();
}

void RunProcesses::wait() const {
  std::vector<pollfd> ends;
  for (const auto& [pid, job] : children_)
    if (const auto end = static_cast<int>(syscall(SYS_pidfd_open, pid, 0)); end >= 0) ends.push_back({end, POLLIN, 0});
  // Kernels before 5.3 have no pidfd_open: there this sleeps for 20 ms.
  poll(ends.data(), ends.size(), ends.size() == children_.size() ? 100 : 20);  // [ms]
  for (const pollfd& end : ends) close(end.fd);
}

void RunProcesses::pause() {
  const Clock::time_point begin = Clock::now();
  for (const auto& [pid, job] : children_) kill(-pid, SIGSTOP);
  raise(SIGSTOP);
  for (auto& [pid, job] : children_) {
    job.begun += Clock::now() - begin;
    if (job.kept) *job.kept += Clock::now() - begin;
    kill(-pid, SIGCONT);
  }
}

void RunProcesses::stop() {
  for (const auto& [pid, job] : children_) {
    kill(-pid, SIGKILL);
    kill(pid, SIGKILL);
    wait_for_end(pid);
    disk().remove_all(partial_folder(out_, job.id));
    notes_.push_back(name_of(job) + " was stopped" + describe_place(progress_[job.slot].last));
  }
  children_.clear();
  end_orphans();
}

std::string RunProcesses::name_of(const Job& job) { return job.id.stack + ", seed " + std::to_string(job.id.seed); }

void RunProcesses::settle(const Job& job, int status) {
  RunProgress& progress = progress_[job.slot];
  progress.fraction.store(1.0, std::memory_order_relaxed);
  const std::string why = (job.ended_because.empty() ? "its process " + describe_end(status) : job.ended_because);
  const bool killed = job.ended_because.empty() && WIFSIGNALED(status) && ends_from_outside(WTERMSIG(status));
  if (progress.disk_refused.load() || (killed && !progress.kept.load())) cut_off_.push_back(job.id);
  // A plugin that calls exit(0) makes the process look successful although its results are missing.
  if (!progress.kept.load()) {
    const std::string early = WIFEXITED(status) && job.ended_because.empty() ? " before the race did" : "";
    const bool lost = WIFEXITED(status) && WEXITSTATUS(status) == run_lost;
    keep_broken_run(race_, job.id, out_, job.key,
                    why + early + describe_place(progress.last) + (lost ? plugins_of(race_, job.id) : ""));
  } else if (status != 0) {
    notes_.push_back(name_of(job) + " is complete; afterwards " + why + describe_place(progress.last));
  }
}

/// Ends a run beyond its time limit, and one that does not end within 5 s after its results were kept.
void RunProcesses::watch(pid_t pid, Job& job) {
  constexpr auto for_destructors = std::chrono::seconds(5);
  const Clock::time_point now = Clock::now();
  if (!job.kept && progress_[job.slot].kept.load()) job.kept = now;
  const auto limit = std::chrono::duration<double>(limits_.timeout_s);
  if (job.kept ? now - *job.kept < for_destructors : limits_.timeout_s <= 0 || now - job.begun < limit) return;
  job.ended_because = job.kept ? "its process did not end by itself and was ended"
                               : "it was stopped after " + number_text(limits_.timeout_s) + " s (--timeout)";
  kill(-pid, SIGKILL);
  kill(pid, SIGKILL);
}

/// Processes that runs started, which are children of this process once the run itself has ended. Children that other
/// parts of this process started are none of them.
void RunProcesses::end_orphans() {
  for (const pid_t pid : children_of_this_process()) {
    if (children_.contains(pid) || !mark_.is_on(pid)) continue;
    kill(pid, SIGKILL);
    wait_for_end(pid);
  }
}

}  // namespace gripline
