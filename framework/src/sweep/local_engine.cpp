#include "sweep/local_engine.hpp"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <iostream>
#include <map>

#include "config/errors.hpp"
#include "experiment/out_folder.hpp"
#include "util/child_process.hpp"
#include "util/progress.hpp"
#include "util/shared_array.hpp"
#include "util/signals.hpp"

namespace gripline::sweep {
namespace {

constexpr std::int64_t no_task = -1;
constexpr std::int64_t all_done = -2;

/// Shared by the workers and the process that started them. `task` is what each worker does now, no_task between two
/// of them, or all_done where the worker ended as it should.
struct Shared {
  static constexpr std::size_t most_workers = 4096;
  std::atomic<std::size_t> next{0}, runs{0};
  std::atomic<std::int64_t> task[most_workers];

  Shared() {
    for (auto& one : task) one.store(no_task);
  }
};

/// The body of a worker process: the task that a worker that died left to it, if there is one, then task after task.
[[noreturn]] void work(const Batch& batch, Shared& shared, std::size_t worker, pid_t parent,
                       const LocalEngine::Opener& open) {
  setpgid(0, 0);  // so that Ctrl-C on the terminal reaches the parent only
  std::signal(SIGINT, SIG_IGN);
  for (const int number : {SIGTERM, SIGCHLD, SIGTSTP}) std::signal(number, SIG_DFL);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(task_again);
  OutLock::leave_to_parent();
  end_at_exit();
  bool opened = false;
  int end = task_done;
  try {
    const TaskBody body = open(worker);
    opened = true;
    for (std::int64_t task = shared.task[worker].load();; task = no_task) {
      if (task == no_task) task = static_cast<std::int64_t>(shared.next.fetch_add(1));
      if (task >= static_cast<std::int64_t>(batch.tasks())) break;
      shared.task[worker].store(task);
      const int code = body(batch, static_cast<std::size_t>(task), [&] { shared.runs.fetch_add(1); });
      shared.task[worker].store(no_task);
      if (code == task_refused || StopSignal::seen()) break;
    }
  } catch (const std::exception& e) {
    std::cerr << escape_control(e.what()) << '\n';
    // A task that was handed on but not begun is handed on again. Otherwise another worker would fail the same way.
    if (!opened && shared.task[worker].load() != no_task) end = task_again;
  }
  if (end == task_done) shared.task[worker].store(all_done);
  std::cout.flush();
  std::cerr.flush();
  _exit(end);
}

class Workers {
 public:
  Workers(const Batch& batch, const LocalEngine::Opener& open) : batch_(batch), open_(open) {}
  ~Workers() { stop(); }
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;
  std::size_t running() const { return workers_.size(); }
  std::size_t runs() { return shared_.runs.load(); }

  /// `first` is the worker's from now on, so that it outlives a process that dies before it is begun.
  void start(std::size_t worker, std::int64_t first) {
    shared_.task[worker].store(first);
    const pid_t parent = getpid(), pid = fork_process();
    if (pid == 0) work(batch_, shared_, worker, parent, open_);
    setpgid(pid, pid);
    workers_[pid] = worker;
  }

  /// Collects workers that ended; one that died is replaced. What a worker said itself counts: a library may have
  /// ended it with exit code 0, and there is no status where SIGCHLD is ignored.
  void reap() {
    for (auto at = workers_.begin(); at != workers_.end();) {
      int status = 0;
      const pid_t ended = waitpid(at->first, &status, WNOHANG);
      if (ended == 0) {
        ++at;
        continue;
      }
      const std::size_t worker = at->second;
      at = workers_.erase(at);
      if (shared_.task[worker].load() != all_done)
        replace(worker, ended > 0 ? describe_end(status) : "ended, nobody knows how");
    }
  }

  /// Sends SIGTERM, and SIGKILL to those that still run after 4 s.
  void stop() {
    for (const auto& [pid, worker] : workers_) kill(pid, SIGTERM);
    constexpr int tries = 200;  // every 20 ms
    for (int i = 0; i < tries && !workers_.empty(); ++i) {
      std::erase_if(workers_, [](const auto& one) { return waitpid(one.first, nullptr, WNOHANG) != 0; });
      if (!workers_.empty()) usleep(20'000);
    }
    for (const auto& [pid, worker] : workers_) {
      kill(-pid, SIGKILL);
      wait_for_end(pid);
    }
    workers_.clear();
  }

 private:
  void replace(std::size_t worker, const std::string& end) {
    constexpr int most_tries = 3;
    const std::int64_t task = shared_.task[worker].load();
    std::cerr << "a worker " << end << '\n';
    if (task == no_task) {  // as it opened the sweep, most likely: others in its place may die the same way
      if (++idle_deaths_[worker] <= most_tries) return start(worker, no_task);
      std::cerr << "worker " << worker << " is given up\n";
      return;
    }
    if (++tries_[task] <= most_tries) return start(worker, task);
    std::cerr << "task " << task << " is given up\n";
    start(worker, no_task);
  }

  const Batch& batch_;
  const LocalEngine::Opener& open_;
  SharedArray<Shared> memory_{1};
  Shared& shared_ = memory_[0];
  std::map<pid_t, std::size_t> workers_;
  std::map<std::int64_t, int> tries_;       // by task
  std::map<std::size_t, int> idle_deaths_;  // without a task, by worker
};

}  // namespace

std::string LocalEngine::plan(const Batch& batch) const {
  return std::to_string(batch.tasks()) + " tasks of at most " + std::to_string(batch.chunk) + " runs for " +
         std::to_string(std::min(static_cast<std::size_t>(jobs_), batch.tasks())) + " worker processes here";
}

void LocalEngine::submit(const Batch& batch, Submission& submission, const std::function<void()>& keep) {
  submission.engine = "local";
  keep();
  const StopSignal stop(StopSignal::Reaction::note);
  Workers workers(batch, open_);
  const std::size_t count =
      std::min({static_cast<std::size_t>(jobs_), batch.tasks(), static_cast<std::size_t>(Shared::most_workers)});
  for (std::size_t worker = 0; worker < count; ++worker) workers.start(worker, no_task);
  {
    Progress progress(std::cerr, name_, batch.runs);
    while (workers.running() > 0 && !StopSignal::seen()) {
      workers.reap();
      if (show_progress_) progress.advance(std::min(workers.runs(), batch.runs), "");
      if (workers.running() > 0) usleep(50'000);
    }
    if (show_progress_ && !StopSignal::seen()) progress.finish();
  }
  interrupted_ = StopSignal::seen();
  workers.stop();
}

}  // namespace gripline::sweep
