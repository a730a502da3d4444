#include "experiment/race_runner.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstring>
#include <iostream>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "config/hash.hpp"
#include "config/json_file.hpp"
#include "config/shipped.hpp"
#include "experiment/out_folder.hpp"
#include "plugin/plugin_cache.hpp"
#include "race/assembly.hpp"
#include "util/child_process.hpp"
#include "util/csv_writer.hpp"
#include "util/disk.hpp"
#include "util/process_state.hpp"
#include "util/progress.hpp"
#include "util/signals.hpp"

namespace gripline {
namespace fs = std::filesystem;
namespace {

fs::path run_folder(const fs::path& out, const RunId& id) { return out / id.stack / std::to_string(id.seed); }
fs::path partial_folder(const fs::path& out, const RunId& id) {
  return out / id.stack / ("." + std::to_string(id.seed) + ".partial");
}

/// One place per run that children write and the parent reads.
class SharedProgress {
 public:
  explicit SharedProgress(std::size_t count) : count_(std::max<std::size_t>(count, 1)) {
    void* const memory =
        mmap(nullptr, count_ * sizeof(RunProgress), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::runtime_error(std::string("no shared memory: ") + std::strerror(errno));
    slots_ = static_cast<RunProgress*>(memory);
    for (std::size_t i = 0; i < count_; ++i) new (slots_ + i) RunProgress;
  }
  ~SharedProgress() { munmap(slots_, count_ * sizeof(RunProgress)); }
  SharedProgress(const SharedProgress&) = delete;
  SharedProgress& operator=(const SharedProgress&) = delete;
  RunProgress* slot(std::size_t i) { return slots_ + i; }
  const RunProgress* slot(std::size_t i) const { return slots_ + i; }
  double sum() const {
    double total = 0.0;
    for (std::size_t i = 0; i < count_; ++i) total += slots_[i].fraction.load(std::memory_order_relaxed);
    return total;
  }

 private:
  std::size_t count_;
  RunProgress* slots_;
};

constexpr int run_lost = 4;  // exit code of a process that could not leave a summary

/// A broken run is shown but never counted as done: its key is not the one a rerun looks for.
std::string broken_key(const std::string& key) { return "broken " + key; }

/// Writes the summary beside the run's files and puts them all in the place of what an older version left there.
void keep_run(const RunSummary& summary, const std::string& key, const fs::path& out) {
  const RunId id = {summary.stack, summary.seed};
  const fs::path partial = partial_folder(out, id), folder = run_folder(out, id);
  write_summary(partial, summary, key);
  if (!disk().sync_folder(partial)) throw std::runtime_error("cannot write " + partial.string());
  disk().remove_all(folder);
  if (!disk().rename(partial, folder))
    throw std::runtime_error("cannot write " + folder.string() + ": " + std::strerror(errno));
  (void)disk().sync_folder(folder.parent_path());  // a run whose name is lost is driven again
}

/// The same of a run that is another one to the last bit.
void keep_twin(const RunResult& driven, std::uint64_t seed, const std::string& key, const fs::path& out) {
  const RunId id = {driven.summary.stack, seed};
  const fs::path partial = partial_folder(out, id), folder = run_folder(out, id);
  disk().remove_all(partial);
  disk().make_folders(partial);
  write_twin(partial, driven, seed, key);
  disk().remove_all(folder);
  if (!disk().rename(partial, folder))
    throw std::runtime_error("cannot write " + folder.string() + ": " + std::strerror(errno));
}

/// What a race wrote must be there in the end.
void require_files(const fs::path& folder) {
  std::error_code failed;
  for (const char* name : {"config.json", "steps.csv", "timing.csv", "replay.csv", "tyres.csv"})
    if (!fs::is_regular_file(folder / name, failed)) throw std::runtime_error(std::string(name) + " was taken away");
}

/// Keeps the rows of a run whose process broke off, with a summary that says why.
void keep_broken_run(const RaceSpec& race, const RunId& id, const fs::path& out, const std::string& key,
                     const std::string& why) {
  disk().make_folders(partial_folder(out, id));
  RunSummary summary;
  summary.stack = id.stack;
  summary.seed = id.seed;
  summary.status = Status::error;
  summary.message = why;
  for (const StackSpec& stack : race.stacks)
    if (stack.name == id.stack) summary.needs_truth = stack.needs_truth();
  keep_run(summary, broken_key(key), out);
}

/// For a failure that none of them is caught at: a file that was closed, a limit that was set.
std::string plugins_of(const RaceSpec& race, const RunId& id) {
  std::string names;
  for (const StackSpec& stack : race.stacks) {
    if (stack.name != id.stack) continue;
    names = stack.model.model.id();
    for (const PluginSpec& effect : stack.model.effects) names += ", " + effect.id();
    for (const PluginSpec* one : {&stack.estimator, &stack.planner, &stack.controller})
      if (!one->empty()) names += ", " + one->id();
  }
  return " (plugins of this run: " + names + ")";
}

/// Data that this process may have from now on; what it cannot have makes its allocations fail.
void limit_memory(std::size_t megabytes) {
  if (megabytes == 0) return;
  const rlim_t bytes = static_cast<rlim_t>(megabytes) << 20U;
  const rlimit limit{bytes, bytes};
  setrlimit(RLIMIT_DATA, &limit);
}

/// What this run drew, for whoever reads its folder.
void write_draw(const fs::path& folder, const Draw& draw) {
  Node node{Node::Object{}};
  for (const auto& [name, value] : {std::pair{"along_m", draw.along},
                                    {"across_m", draw.across},
                                    {"heading_rad", draw.heading},
                                    {"speed_mps", draw.speed},
                                    {"pace", draw.pace}})
    node.set(name, Node(value));
  write_file(folder / "draw.json", to_json_text(node));
}

/// The body of a run's process: output goes to log.txt, results to the folder of the run.
[[noreturn]] void child(const RaceSpec& race, const RunId& id, const std::string& key, const RunnerOptions& options,
                        pid_t parent, RunProgress* progress) {
  setpgid(0, 0);                  // what it starts ends with it
  std::signal(SIGINT, SIG_IGN);   // the parent decides
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is told as a full disk is
  for (const int number : {SIGTERM, SIGCHLD, SIGTSTP, SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL})
    std::signal(number, SIG_DFL);
  prctl(PR_SET_PDEATHSIG, SIGKILL);          // ends with the parent
  if (getppid() != parent) _exit(run_lost);  // the parent ended before the line above
  OutLock::leave_to_parent();
  limit_memory(options.memory_mb);
  last_call() = &progress->last;
  int code = 0;
  try {
    std::string why;
    try {
      fs::create_directories(partial_folder(options.out, id));
      const fs::path log = partial_folder(options.out, id) / "log.txt";
      if (const int nothing = open("/dev/null", O_RDONLY); nothing >= 0) {
        dup2(nothing, STDIN_FILENO);
        if (nothing > STDERR_FILENO) close(nothing);
      }
      if (const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644); file >= 0) {
        dup2(file, STDOUT_FILENO);
        dup2(file, STDERR_FILENO);
        if (file > STDERR_FILENO) close(file);
      }
      run_here(race, id, key, options.out, progress);
    } catch (const std::bad_alloc&) {
      why = "ran out of memory" + describe_place(progress->last);
    } catch (const std::exception& e) {
      why = e.what() + describe_place(progress->last) + plugins_of(race, id);
    }
    if (!progress->kept.load() && !why.empty()) {
      keep_broken_run(race, id, options.out, key, why);
      progress->kept.store(true);
    }
  } catch (const std::exception&) {
    code = run_lost;
  }
  std::cout.flush();
  _exit(code);
}

/// Ctrl-Z: noted here, because the runs are no part of the terminal's group and go on by themselves.
volatile std::sig_atomic_t pause_seen = 0;
void note_pause(int) { pause_seen = 1; }

class PauseWatch {
 public:
  PauseWatch() {
    pause_seen = 0;
    struct sigaction action {};
    action.sa_handler = note_pause;
    sigaction(SIGTSTP, nullptr, &before_);
    if (before_.sa_handler != SIG_IGN) sigaction(SIGTSTP, &action, nullptr);
  }
  ~PauseWatch() { sigaction(SIGTSTP, &before_, nullptr); }
  PauseWatch(const PauseWatch&) = delete;
  PauseWatch& operator=(const PauseWatch&) = delete;

 private:
  struct sigaction before_ {};
};

/// Children end where the parent waits for them, whatever it was started with; what they leave behind comes to us.
class ParentOfRuns {
 public:
  ParentOfRuns() {
    struct sigaction usual {};
    usual.sa_handler = SIG_DFL;
    sigaction(SIGCHLD, &usual, &before_);
    prctl(PR_GET_CHILD_SUBREAPER, &was_subreaper_);
    prctl(PR_SET_CHILD_SUBREAPER, 1);
  }
  ~ParentOfRuns() {
    prctl(PR_SET_CHILD_SUBREAPER, was_subreaper_);
    sigaction(SIGCHLD, &before_, nullptr);
  }
  ParentOfRuns(const ParentOfRuns&) = delete;
  ParentOfRuns& operator=(const ParentOfRuns&) = delete;

 private:
  struct sigaction before_ {};
  int was_subreaper_ = 0;
};

class Pool {
 public:
  Pool(const RaceSpec& race, const RunnerOptions& options, std::size_t count)
      : race_(race), options_(options), progress_(count), strangers_(children_of_this_process()) {}
  ~Pool() { stop(); }
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;
  std::size_t running() const { return children_.size(); }
  bool is_running(std::size_t slot) const {
    return std::any_of(children_.begin(), children_.end(), [&](const auto& one) { return one.second.slot == slot; });
  }
  /// Counts as done without a start.
  void skip(std::size_t slot) { progress_.slot(slot)->fraction.store(1.0, std::memory_order_relaxed); }
  double fractions() const { return progress_.sum(); }
  std::vector<std::string>& notes() { return notes_; }
  std::string names() const {
    std::string text;
    for (const auto& [pid, job] : children_) {
      text += (text.empty() ? "" : ", ") + job.id.stack +
              (race_.seeds.size() > 1 ? " seed " + std::to_string(job.id.seed) : "");
      const RunProgress& now = *progress_.slot(job.slot);
      const double preparing = now.preparing.load(std::memory_order_relaxed);
      if (preparing >= 0 && now.fraction.load(std::memory_order_relaxed) <= 0)
        text += " (" + now.what.get() + " " + std::to_string(std::lround(100 * std::min(preparing, 1.0))) + " %)";
    }
    return text;
  }

  void start(const RunId& id, const std::string& key, std::size_t slot) {
    disk().remove_all(partial_folder(options_.out, id));
    std::cout.flush();
    std::cerr.flush();
    const pid_t parent = getpid(), pid = fork();
    if (pid < 0) throw std::runtime_error(std::string("cannot start a process: ") + std::strerror(errno));
    if (pid == 0) child(race_, id, key, options_, parent, progress_.slot(slot));
    setpgid(pid, pid);
    children_[pid] = {id, key, slot, Clock::now(), {}, {}};
  }

  /// Collects every process that ended, and ends those that take too long.
  void reap() {
    for (auto at = children_.begin(); at != children_.end();) {
      const auto next = std::next(at);
      if (const std::optional<int> status = ended(at->first)) {
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

  /// Returns when a run ends, and soon after in any case.
  void wait() const {
    std::vector<pollfd> ends;
    for (const auto& [pid, job] : children_)
      if (const auto end = static_cast<int>(syscall(SYS_pidfd_open, pid, 0)); end >= 0)
        ends.push_back({end, POLLIN, 0});
    // A signal ends it too. Kernels before 5.3 know no pidfd_open: there it sleeps, not for long.
    poll(ends.data(), ends.size(), ends.size() == children_.size() ? 100 : 20);  // [ms]
    for (const pollfd& end : ends) close(end.fd);
  }

  /// Ctrl-Z: they stop and go on with this process; the time in between does not count.
  void pause() {
    const Clock::time_point begin = Clock::now();
    for (const auto& [pid, job] : children_) kill(-pid, SIGSTOP);
    raise(SIGSTOP);
    for (auto& [pid, job] : children_) {
      job.begun += Clock::now() - begin;
      if (job.kept) *job.kept += Clock::now() - begin;
      kill(-pid, SIGCONT);
    }
  }

  void stop() {
    for (const auto& [pid, job] : children_) {
      kill(-pid, SIGKILL);
      kill(pid, SIGKILL);
      waitpid(pid, nullptr, 0);
      disk().remove_all(partial_folder(options_.out, job.id));
      notes_.push_back(name_of(job) + " was stopped" + describe_place(progress_.slot(job.slot)->last));
    }
    children_.clear();
    end_orphans();
  }

 private:
  using Clock = std::chrono::steady_clock;
  struct Job {
    RunId id;
    std::string key;
    std::size_t slot;
    Clock::time_point begun;
    std::optional<Clock::time_point> kept;  // since when its results are there
    std::string ended_because;              // of us; empty: by itself
  };

  static std::string name_of(const Job& job) { return job.id.stack + ", seed " + std::to_string(job.id.seed); }

  /// The status of a process that ended, collected with all it started.
  static std::optional<int> ended(pid_t pid) {
    siginfo_t info{};
    const int result = waitid(P_PID, static_cast<id_t>(pid), &info, WEXITED | WNOHANG | WNOWAIT);
    if (result == 0 && info.si_pid == 0) return std::nullopt;
    kill(-pid, SIGKILL);  // while its number is still its own
    int status = 0;
    if (result != 0 || waitpid(pid, &status, 0) != pid) return 0;  // collected elsewhere: its files tell the rest
    return status;
  }

  void settle(const Job& job, int status) {
    RunProgress& progress = *progress_.slot(job.slot);
    progress.fraction.store(1.0, std::memory_order_relaxed);
    const std::string why = (job.ended_because.empty() ? "its process " + describe_end(status) : job.ended_because);
    // A plugin may have called exit(0): then its process looks well, and what it was to leave is not there.
    if (!progress.kept.load()) {
      const std::string early = WIFEXITED(status) && job.ended_because.empty() ? " before the race did" : "";
      const bool lost = WIFEXITED(status) && WEXITSTATUS(status) == run_lost;
      keep_broken_run(race_, job.id, options_.out, job.key,
                      why + early + describe_place(progress.last) + (lost ? plugins_of(race_, job.id) : ""));
    } else if (status != 0) {
      notes_.push_back(name_of(job) + " is complete; afterwards " + why + describe_place(progress.last));
    }
  }

  void watch(pid_t pid, Job& job) {
    constexpr auto patience = std::chrono::seconds(5);  // for destructors
    const Clock::time_point now = Clock::now();
    if (!job.kept && progress_.slot(job.slot)->kept.load()) job.kept = now;
    const auto limit = std::chrono::duration<double>(options_.timeout_s);
    if (job.kept ? now - *job.kept < patience : options_.timeout_s <= 0 || now - job.begun < limit) return;
    job.ended_because = job.kept ? "its process did not end by itself and was ended"
                                 : "it was stopped after " + number_text(options_.timeout_s) + " s (--timeout)";
    kill(-pid, SIGKILL);
    kill(pid, SIGKILL);
  }

  /// Processes that runs started and left to us.
  void end_orphans() {
    for (const pid_t pid : children_of_this_process()) {
      if (children_.contains(pid) || std::find(strangers_.begin(), strangers_.end(), pid) != strangers_.end()) continue;
      kill(pid, SIGKILL);
      waitpid(pid, nullptr, 0);
    }
  }

  const RaceSpec& race_;
  const RunnerOptions& options_;
  SharedProgress progress_;
  std::vector<pid_t> strangers_;  // that were here before
  std::map<pid_t, Job> children_;
  std::vector<std::string> notes_;
};

}  // namespace

std::string run_key(const RaceSpec& race, const RunId& id, FileHashes& hashes) {
  Node tree = race.run_tree(id.stack, id.seed);
  tree.erase("claim_share");  // asked of results
  std::string text = content_text(tree);
  text += "\n" + hashes.of(program_file()) + "\n";
  for (const fs::path& file : files_named(tree)) text += hashes.of(file);
  const auto stack =
      std::find_if(race.stacks.begin(), race.stacks.end(), [&](const auto& s) { return s.name == id.stack; });
  for (const fs::path& library : libraries_of(race.world, std::span(&*stack, 1)))
    text += library.filename().string() + hashes.of(library);
  return sha256_hex(text);
}

const std::string& FileHashes::of(const fs::path& file) {
  auto [found, fresh] = known_.try_emplace(file);
  if (fresh) found->second = sha256_of_file(file);
  return found->second;
}

RunSummary run_here(const RaceSpec& race, const RunId& id, const std::string& key, const fs::path& out_folder,
                    RunProgress* progress) {
  const fs::path out = fs::absolute(out_folder);  // a plugin may go elsewhere
  const auto spec =
      std::find_if(race.stacks.begin(), race.stacks.end(), [&](const auto& s) { return s.name == id.stack; });
  const fs::path partial = partial_folder(out, id);
  if (!disk().make_folders(partial))
    throw std::runtime_error("cannot make " + partial.string() + ": " + std::strerror(errno));
  write_file(partial / "config.json", to_json_text(race.run_tree(id.stack, id.seed)));
  RunSummary summary;
  summary.stack = id.stack;
  summary.seed = id.seed;
  summary.needs_truth = spec->needs_truth();
  bool kept = false;
  std::optional<ProcessState> state(std::in_place);
  const auto keep = [&] {
    const bool broken = summary.status == Status::plugin_error || summary.status == Status::error;
    keep_run(summary, broken ? broken_key(key) : key, out);
    kept = true;
    if (progress != nullptr) progress->kept.store(true);
  };
  try {
    RaceSetup setup;
    setup.seed = id.seed;
    setup.folder = partial;
    setup.cache_dir = plugin_cache_folder();
    if (progress != nullptr) {
      setup.preparing_context = progress;
      setup.on_preparing = [](void* context, const char* what, double fraction) {
        auto* const shown = static_cast<RunProgress*>(context);
        shown->what.set(what != nullptr ? what : "preparing");
        shown->preparing.store(fraction, std::memory_order_relaxed);
      };
    }
    WorldSpec world = race.world;
    StackSpec stack = *spec;
    if (const std::optional<Draw> draw = perturb(race.perturb, id.seed, world, stack)) write_draw(partial, *draw);
    RaceAssembly assembly(world, stack, setup);
    if (progress != nullptr)
      assembly.simulation().on_progress(
          [](void* context, double fraction) {
            static_cast<std::atomic<double>*>(context)->store(fraction, std::memory_order_relaxed);
          },
          &progress->fraction);
    summary = assembly.run();
    state.reset();
    require_files(partial);
    keep();  // before plugins are destroyed: one that fails then spoils no result
  } catch (const PluginError& e) {
    summary.status = Status::plugin_error;
    summary.message = e.what();
  } catch (const PluginFailure& e) {
    summary.status = Status::plugin_error;
    summary.message = e.what();
  }
  state.reset();
  if (!kept) keep();
  return summary;
}

double default_timeout(const WorldSpec& world) {
  constexpr double preparing = 600;  // [s] of a plugin that computes a library of laps
  constexpr double per_second = 60;  // of wall clock per second driven: ten times the slowest of ours on one busy core
  const double driven = world.laps > 0 ? world.timeout : world.duration.value_or(world.timeout);
  return preparing + per_second * driven;
}

std::vector<RunResult> results_in(const RaceSpec& race, const fs::path& out) {
  std::vector<RunResult> all;
  FileHashes hashes;
  for (const StackSpec& stack : race.stacks) {
    std::vector<std::uint64_t> seeds;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(out / stack.name, ignored)) {
      const std::string name = entry.path().filename().string();
      std::uint64_t seed = 0;
      std::from_chars(name.data(), name.data() + name.size(), seed);
      if (std::to_string(seed) == name) seeds.push_back(seed);
    }
    std::sort(seeds.begin(), seeds.end());
    for (const std::uint64_t seed : seeds) {
      const RunId id = {stack.name, seed};
      const std::string key = run_key(race, id, hashes);
      std::optional<RunResult> result = read_result(run_folder(out, id), key);
      if (!result) result = read_result(run_folder(out, id), broken_key(key));
      if (result) all.push_back(*std::move(result));
    }
  }
  return all;
}

namespace {

/// Whether a world or a start is another one for another seed, whatever the plugins do.
bool draws_from_seed(const RaceSpec& race) {
  if (race.perturb.any() || race.world.friction.shift_per_seed != 0.0) return true;
  const auto& channels = race.world.sensors.channels;
  return std::any_of(channels.begin(), channels.end(), [](const auto& channel) { return channel.sigma != 0.0; });
}

/// What is asked for and where it is found.
struct Asked {
  const std::vector<RunId>& ids;
  std::vector<std::string> keys;
  fs::path out;

  std::optional<RunResult> finished(std::size_t i, std::string* damage = nullptr) const {
    return read_result(run_folder(out, ids[i]), keys[i], damage);
  }
  std::optional<RunResult> broken(std::size_t i) const {
    return read_result(run_folder(out, ids[i]), broken_key(keys[i]));
  }
};

/// The runs that are left, in the order asked for. Where nothing is drawn from the seed, those of a stack beyond its
/// first two seeds wait for these, and are those when they are one.
class Queue {
 public:
  Queue(const RaceSpec& race, const Asked& asked, const std::vector<std::size_t>& left) : asked_(asked) {
    std::map<std::string, std::vector<std::size_t>> of_stack;
    if (!draws_from_seed(race))
      for (std::size_t i = 0; i < asked.ids.size(); ++i) of_stack[asked.ids[i].stack].push_back(i);
    for (const std::size_t run : left) {
      const std::vector<std::size_t>& all = of_stack[asked.ids[run].stack];
      const bool waits = all.size() > 2 && run != all[0] && run != all[1];
      entries_.push_back({run, waits ? std::optional(std::pair(all[0], all[1])) : std::nullopt});
    }
  }
  bool empty() const {
    return std::all_of(entries_.begin(), entries_.end(), [](const Entry& one) { return one.taken; });
  }
  std::size_t run(std::size_t slot) const { return entries_[slot].run; }
  /// The slot of a run to start now, if there is one.
  std::optional<std::size_t> next(Pool& pool) {
    for (std::size_t slot = 0; slot < entries_.size(); ++slot) {
      Entry& one = entries_[slot];
      if (one.taken || (one.pair && !(settled(one.pair->first, pool) && settled(one.pair->second, pool)))) continue;
      one.taken = true;
      const std::optional<RunResult> driven = one.pair ? same(*one.pair) : std::nullopt;
      if (!driven) return slot;
      keep_twin(*driven, asked_.ids[one.run].seed, asked_.keys[one.run], asked_.out);
      pool.skip(slot);
    }
    return std::nullopt;
  }

 private:
  struct Entry {
    std::size_t run;
    std::optional<std::pair<std::size_t, std::size_t>> pair;  // it waits for
    bool taken = false;
  };
  bool settled(std::size_t run, const Pool& pool) const {
    for (std::size_t slot = 0; slot < entries_.size(); ++slot)
      if (entries_[slot].run == run) return entries_[slot].taken && !pool.is_running(slot);
    return true;  // it was there
  }
  /// The first of two runs, when both are finished and the same.
  std::optional<RunResult> same(const std::pair<std::size_t, std::size_t>& pair) const {
    std::optional<RunResult> a = asked_.finished(pair.first);
    const std::optional<RunResult> b = asked_.finished(pair.second);
    return a && b && !a->drive.empty() && a->drive == b->drive ? a : std::nullopt;
  }

  const Asked& asked_;
  std::vector<Entry> entries_;
};

/// The results as they stand on the disk, in the order asked for. Of other inputs they have another key, and count as
/// absent.
std::vector<RunResult> collect(const Asked& asked, bool interrupted) {
  std::vector<RunResult> runs;
  for (std::size_t i = 0; i < asked.ids.size(); ++i) {
    std::optional<RunResult> result = asked.finished(i);
    if (!result) result = asked.broken(i);
    if (!result && interrupted) continue;
    if (!result) {
      result.emplace();
      result->summary.stack = asked.ids[i].stack;
      result->summary.seed = asked.ids[i].seed;
      result->summary.message = "left no result";
    }
    runs.push_back(*std::move(result));
  }
  return runs;
}

/// What is not there yet; says what was, in `outcome`.
std::vector<std::size_t> left_of(const Asked& asked, RunnerOutcome& outcome) {
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < asked.ids.size(); ++i) {
    std::string damage;
    if (asked.finished(i, &damage)) {
      ++outcome.kept;
      continue;
    }
    left.push_back(i);
    const std::optional<RunResult> other = read_result(run_folder(asked.out, asked.ids[i]), "");
    const bool done = other && other->summary.status != Status::error && other->summary.status != Status::plugin_error;
    if (done) ++outcome.replaced;
    if (!damage.empty())
      outcome.notes.push_back(asked.ids[i].stack + ", seed " + std::to_string(asked.ids[i].seed) + ": " + damage +
                              " since it was raced; it is driven again");
  }
  return left;
}

}  // namespace

RunnerOutcome run_all(const RaceSpec& race, const std::vector<RunId>& ids, const RunnerOptions& given) {
  RunnerOptions options = given;
  options.out = fs::absolute(given.out);
  if (options.timeout_s <= 0) options.timeout_s = default_timeout(race.world);
  RunnerOutcome outcome;
  Asked asked{ids, {}, options.out};
  FileHashes own;
  FileHashes& hashes = options.hashes != nullptr ? *options.hashes : own;
  for (const RunId& id : ids) asked.keys.push_back(run_key(race, id, hashes));
  const std::vector<std::size_t> left = left_of(asked, outcome);
  const StopSignal stop(StopSignal::Reaction::note);
  const PauseWatch pauses;
  const ParentOfRuns parent;
  Pool pool(race, options, left.size());
  Queue queue(race, asked, left);
  {
    Progress progress(std::cerr, race.name, std::max<std::size_t>(1, left.size() * 1000));
    progress.count_in(1000);
    while ((!queue.empty() || pool.running() > 0) && !StopSignal::seen()) {
      while (pool.running() < static_cast<std::size_t>(options.jobs)) {
        const std::optional<std::size_t> slot = queue.next(pool);
        if (!slot) break;
        pool.start(ids[queue.run(*slot)], asked.keys[queue.run(*slot)], *slot);
      }
      pool.reap();
      if (options.show_progress) progress.advance(static_cast<std::size_t>(pool.fractions() * 1000), pool.names());
      if (std::exchange(pause_seen, 0) != 0) pool.pause();
      if (pool.running() > 0) pool.wait();
    }
    if (options.show_progress && !StopSignal::seen()) progress.finish();
  }
  outcome.interrupted = StopSignal::seen();
  pool.stop();
  outcome.notes.insert(outcome.notes.end(), pool.notes().begin(), pool.notes().end());
  outcome.runs = collect(asked, outcome.interrupted);
  return outcome;
}

}  // namespace gripline
