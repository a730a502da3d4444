#include "experiment/race_runner.hpp"

#include <algorithm>
#include <charconv>
#include <iostream>
#include <map>
#include <optional>
#include <utility>

#include "experiment/run_folder.hpp"
#include "experiment/run_processes.hpp"
#include "util/progress.hpp"
#include "util/signals.hpp"

namespace gripline {
namespace fs = std::filesystem;

double default_timeout(const WorldSpec& world) {
  constexpr double preparing = 600;  // [s] for a plugin that computes lap libraries
  constexpr double per_second = 60;  // wall clock per second driven: ten times the slowest shipped stack on a busy core
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

/// Whether the world or the start depends on the seed. Plugins may depend on it as well.
bool draws_from_seed(const RaceSpec& race) {
  if (race.perturb.any() || race.world.friction.shift_per_seed != 0.0) return true;
  const auto& channels = race.world.sensors.channels;
  return std::any_of(channels.begin(), channels.end(), [](const auto& channel) { return channel.sigma != 0.0; });
}

/// The runs that were asked for, and where their results are.
struct RequestedRuns {
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

/// The runs to drive, in the order asked for. Where nothing is drawn from the seed, a stack's runs beyond its first two
/// seeds wait for those two; if they are equal to the last bit, the others are copies of them.
class Queue {
 public:
  Queue(const RaceSpec& race, const RequestedRuns& requested, const std::vector<std::size_t>& left)
      : requested_(requested) {
    std::map<std::string, std::vector<std::size_t>> of_stack;
    if (!draws_from_seed(race))
      for (std::size_t i = 0; i < requested.ids.size(); ++i) of_stack[requested.ids[i].stack].push_back(i);
    for (const std::size_t run : left) {
      const std::vector<std::size_t>& all = of_stack[requested.ids[run].stack];
      const bool waits = all.size() > 2 && run != all[0] && run != all[1];
      entries_.push_back({run, waits ? std::optional(std::pair(all[0], all[1])) : std::nullopt});
    }
  }
  bool empty() const {
    return std::all_of(entries_.begin(), entries_.end(), [](const Entry& one) { return one.taken; });
  }
  std::size_t run(std::size_t slot) const { return entries_[slot].run; }
  /// The slot of a run to start now, if there is one. Copies that have become known are kept on the way.
  std::optional<std::size_t> next(RunProcesses& processes) {
    for (std::size_t slot = 0; slot < entries_.size(); ++slot) {
      Entry& one = entries_[slot];
      if (one.taken || (one.pair && !(settled(one.pair->first, processes) && settled(one.pair->second, processes))))
        continue;
      one.taken = true;
      const std::optional<RunResult> driven = one.pair ? equal_run(*one.pair) : std::nullopt;
      if (!driven) return slot;
      keep_copied_run(*driven, requested_.ids[one.run].seed, requested_.keys[one.run], requested_.out);
      processes.skip(slot);
    }
    return std::nullopt;
  }

 private:
  struct Entry {
    std::size_t run;
    std::optional<std::pair<std::size_t, std::size_t>> pair;  // the runs that it waits for
    bool taken = false;
  };
  bool settled(std::size_t run, const RunProcesses& processes) const {
    for (std::size_t slot = 0; slot < entries_.size(); ++slot)
      if (entries_[slot].run == run) return entries_[slot].taken && !processes.is_running(slot);
    return true;  // finished before this call
  }
  /// The first of two runs if both are finished and equal.
  std::optional<RunResult> equal_run(const std::pair<std::size_t, std::size_t>& pair) const {
    std::optional<RunResult> a = requested_.finished(pair.first);
    const std::optional<RunResult> b = requested_.finished(pair.second);
    return a && b && !a->drive.empty() && a->drive == b->drive ? a : std::nullopt;
  }

  const RequestedRuns& requested_;
  std::vector<Entry> entries_;
};

/// The results on the disk, in the order asked for. Results of other inputs have another key and count as absent.
std::vector<RunResult> collect(const RequestedRuns& requested, bool interrupted) {
  std::vector<RunResult> runs;
  for (std::size_t i = 0; i < requested.ids.size(); ++i) {
    std::optional<RunResult> result = requested.finished(i);
    if (!result) result = requested.broken(i);
    if (!result && interrupted) continue;
    if (!result) {
      result.emplace();
      result->summary.stack = requested.ids[i].stack;
      result->summary.seed = requested.ids[i].seed;
      result->summary.message = "left no result";
    }
    runs.push_back(*std::move(result));
  }
  return runs;
}

/// Indices of the runs that are not finished; counts the others in `outcome`.
std::vector<std::size_t> runs_to_drive(const RequestedRuns& requested, RunnerOutcome& outcome) {
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < requested.ids.size(); ++i) {
    std::string damage;
    if (requested.finished(i, &damage)) {
      ++outcome.kept;
      continue;
    }
    left.push_back(i);
    const std::optional<RunResult> other = read_result(run_folder(requested.out, requested.ids[i]), "");
    const bool done = other && other->summary.status != Status::error && other->summary.status != Status::plugin_error;
    if (done) ++outcome.replaced;
    if (!damage.empty())
      outcome.notes.push_back(requested.ids[i].stack + ", seed " + std::to_string(requested.ids[i].seed) + ": " +
                              damage + " since it was raced; it is driven again");
  }
  return left;
}

}  // namespace

RunnerOutcome run_all(const RaceSpec& race, const std::vector<RunId>& ids, const RunnerOptions& given) {
  RunnerOptions options = given;
  options.out = fs::absolute(given.out);
  if (options.timeout_s <= 0) options.timeout_s = default_timeout(race.world);
  RunnerOutcome outcome;
  RequestedRuns requested{ids, {}, options.out};
  FileHashes own;
  FileHashes& hashes = options.hashes != nullptr ? *options.hashes : own;
  for (const RunId& id : ids) requested.keys.push_back(run_key(race, id, hashes));
  const std::vector<std::size_t> left = runs_to_drive(requested, outcome);
  const StopSignal stop(StopSignal::Reaction::note);
  const PauseWatch pauses;
  const ParentOfRuns parent;
  RunProcesses processes(race, options.out, {options.timeout_s, options.memory_mb, options.jobs == 1}, left.size());
  Queue queue(race, requested, left);
  {
    Progress progress(std::cerr, race.name, std::max<std::size_t>(1, left.size() * 1000));
    progress.count_in(1000);
    while ((!queue.empty() || processes.running() > 0) && !StopSignal::seen()) {
      while (processes.running() < static_cast<std::size_t>(options.jobs)) {
        const std::optional<std::size_t> slot = queue.next(processes);
        if (!slot) break;
        processes.start(ids[queue.run(*slot)], requested.keys[queue.run(*slot)], *slot);
      }
      processes.reap();
      if (options.show_progress)
        progress.advance(static_cast<std::size_t>(processes.fractions() * 1000), processes.names());
      if (PauseWatch::take()) processes.pause();
      if (processes.running() > 0) processes.wait();
    }
    if (options.show_progress && !StopSignal::seen()) progress.finish();
  }
  outcome.interrupted = StopSignal::seen();
  processes.stop();
  outcome.notes.insert(outcome.notes.end(), processes.notes().begin(), processes.notes().end());
  outcome.cut_off = processes.cut_off();
  outcome.runs = collect(requested, outcome.interrupted);
  return outcome;
}

}  // namespace gripline
