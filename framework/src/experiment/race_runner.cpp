#include "experiment/race_runner.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <iostream>
#include <map>

#include "config/hash.hpp"
#include "config/json_file.hpp"
#include "plugin/plugin_cache.hpp"
#include "race/assembly.hpp"
#include "util/csv_writer.hpp"
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

/// Keeps the rows of a run whose process broke off, with a summary that says why.
void keep_broken_run(const RaceSpec& race, const RunId& id, const fs::path& out, const std::string& key,
                     const std::string& why) {
  const fs::path partial = partial_folder(out, id);
  std::error_code ignored;
  fs::create_directories(partial, ignored);
  RunSummary summary;
  summary.stack = id.stack;
  summary.seed = id.seed;
  summary.status = Status::error;
  summary.message = why;
  for (const StackSpec& stack : race.stacks)
    if (stack.name == id.stack) summary.needs_truth = stack.needs_truth();
  write_summary(partial, summary, broken_key(key));
  fs::remove_all(run_folder(out, id), ignored);
  fs::rename(partial, run_folder(out, id), ignored);
}

/// The body of a run's process: output goes to log.txt, results to the folder of the run.
[[noreturn]] void child(const RaceSpec& race, const RunId& id, const std::string& key, const fs::path& out,
                        pid_t parent, RunProgress* progress) {
  std::signal(SIGINT, SIG_IGN);  // the parent decides
  std::signal(SIGTERM, SIG_DFL);
  prctl(PR_SET_PDEATHSIG, SIGKILL);          // ends with the parent
  if (getppid() != parent) _exit(run_lost);  // the parent ended before the line above
  last_call() = &progress->last;
  int code = 0;
  try {
    fs::create_directories(partial_folder(out, id));
    const fs::path log = partial_folder(out, id) / "log.txt";
    if (const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644); file >= 0) {
      dup2(file, STDOUT_FILENO);
      dup2(file, STDERR_FILENO);
      close(file);
    }
    run_here(race, id, key, out, progress);
  } catch (const std::exception& e) {
    try {
      keep_broken_run(race, id, out, key, e.what());
    } catch (const std::exception&) {
      code = run_lost;
    }
  }
  std::cout.flush();
  _exit(code);
}

/// How a process ended that left no summary, and where it was.
std::string describe_exit(int status, const LastCall& last) {
  std::string text;
  if (WIFSIGNALED(status))
    text = "its process was ended by signal " + std::to_string(WTERMSIG(status)) + " (" + strsignal(WTERMSIG(status)) +
           ")";
  else
    text = "its process ended with exit code " + std::to_string(WEXITSTATUS(status)) + " before the race did";
  const std::string who = last.who.get();
  if (who.empty()) return text;
  const double t = last.t.load(std::memory_order_relaxed);
  if (std::isnan(t)) return text + " while " + who + " was made";
  return text + " at t = " + std::to_string(t) + " s; the plugin called last was " + who;
}

class Pool {
 public:
  Pool(const RaceSpec& race, const fs::path& out, std::size_t count) : race_(race), out_(out), progress_(count) {}
  ~Pool() { stop(); }
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;
  std::size_t running() const { return children_.size(); }
  double fractions() const { return progress_.sum(); }
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
    std::error_code ignored;
    fs::remove_all(partial_folder(out_, id), ignored);
    std::cout.flush();
    std::cerr.flush();
    const pid_t parent = getpid(), pid = fork();
    if (pid < 0) throw std::runtime_error(std::string("cannot start a process: ") + std::strerror(errno));
    if (pid == 0) child(race_, id, key, out_, parent, progress_.slot(slot));
    children_[pid] = {id, key, slot};
  }

  /// Collects every process that ended.
  void reap() {
    int status = 0;
    for (pid_t pid = waitpid(-1, &status, WNOHANG); pid > 0; pid = waitpid(-1, &status, WNOHANG)) {
      const auto found = children_.find(pid);
      if (found == children_.end()) continue;
      const Job job = found->second;
      children_.erase(found);
      progress_.slot(job.slot)->fraction.store(1.0, std::memory_order_relaxed);
      // After exit(0) in a plugin the status is good, but the partial folder is still there.
      std::error_code ignored;
      if (status != 0 || fs::exists(partial_folder(out_, job.id), ignored))
        keep_broken_run(race_, job.id, out_, job.key, describe_exit(status, progress_.slot(job.slot)->last));
    }
  }

  void stop() {
    for (const auto& [pid, job] : children_) kill(pid, SIGTERM);
    for (const auto& [pid, job] : children_) {
      int status = 0;
      waitpid(pid, &status, 0);
      std::error_code ignored;
      fs::remove_all(partial_folder(out_, job.id), ignored);
    }
    children_.clear();
  }

 private:
  struct Job {
    RunId id;
    std::string key;
    std::size_t slot;
  };
  const RaceSpec& race_;
  fs::path out_;
  SharedProgress progress_;
  std::map<pid_t, Job> children_;
};

}  // namespace

std::string run_key(const RaceSpec& race, const RunId& id, FileHashes& hashes) {
  const Node tree = race.run_tree(id.stack, id.seed);
  std::string text = content_text(tree);
  text += "\n" + hashes.of("/proc/self/exe") + "\n";  // this program, even when its file was replaced meanwhile
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

RunSummary run_here(const RaceSpec& race, const RunId& id, const std::string& key, const fs::path& out,
                    RunProgress* progress) {
  const auto spec =
      std::find_if(race.stacks.begin(), race.stacks.end(), [&](const auto& s) { return s.name == id.stack; });
  const fs::path partial = partial_folder(out, id);
  fs::create_directories(partial);
  write_file(partial / "config.json", to_json_text(race.run_tree(id.stack, id.seed)));
  RunSummary summary;
  summary.stack = id.stack;
  summary.seed = id.seed;
  summary.needs_truth = spec->needs_truth();
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
    RaceAssembly assembly(race.world, *spec, setup);
    if (progress != nullptr)
      assembly.simulation().on_progress(
          [](void* context, double fraction) {
            static_cast<std::atomic<double>*>(context)->store(fraction, std::memory_order_relaxed);
          },
          &progress->fraction);
    summary = assembly.run();
  } catch (const PluginError& e) {
    summary.status = Status::plugin_error;
    summary.message = e.what();
  } catch (const PluginFailure& e) {
    summary.status = Status::plugin_error;
    summary.message = e.what();
  }
  const bool broken = summary.status == Status::plugin_error || summary.status == Status::error;
  write_summary(partial, summary, broken ? broken_key(key) : key);
  const fs::path folder = run_folder(out, id);
  fs::remove_all(folder);
  fs::rename(partial, folder);
  return summary;
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

RunnerOutcome run_all(const RaceSpec& race, const std::vector<RunId>& ids, const RunnerOptions& options) {
  RunnerOutcome outcome;
  std::vector<std::string> keys;
  std::vector<std::size_t> waiting;
  FileHashes hashes;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    keys.push_back(run_key(race, ids[i], hashes));
    if (read_result(run_folder(options.out, ids[i]), keys[i]))
      ++outcome.kept;
    else
      waiting.push_back(i);
  }
  const StopSignal stop(StopSignal::Reaction::note);
  Pool pool(race, options.out, waiting.size());
  {
    Progress progress(std::cerr, race.name, std::max<std::size_t>(1, waiting.size() * 1000));
    progress.count_in(1000);
    std::size_t next = 0;
    while ((next < waiting.size() || pool.running() > 0) && !StopSignal::seen()) {
      while (next < waiting.size() && pool.running() < static_cast<std::size_t>(options.jobs)) {
        pool.start(ids[waiting[next]], keys[waiting[next]], next);
        ++next;
      }
      pool.reap();
      if (options.show_progress) progress.advance(static_cast<std::size_t>(pool.fractions() * 1000), pool.names());
      if (pool.running() > 0) usleep(20'000);
    }
    if (options.show_progress && !StopSignal::seen()) progress.finish();
  }
  outcome.interrupted = StopSignal::seen();
  pool.stop();
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const RunId& id = ids[i];
    // Results of other inputs have another key and count as absent.
    std::optional<RunResult> result = read_result(run_folder(options.out, id), keys[i]);
    if (!result) result = read_result(run_folder(options.out, id), broken_key(keys[i]));
    if (result) {
      outcome.runs.push_back(*std::move(result));
    } else if (!outcome.interrupted) {
      RunResult lost;
      lost.summary.stack = id.stack;
      lost.summary.seed = id.seed;
      lost.summary.message = "left no result";
      outcome.runs.push_back(std::move(lost));
    }
  }
  return outcome;
}

}  // namespace gripline
