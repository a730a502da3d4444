#include "gripline/sweep_work.hpp"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <optional>
#include <set>
#include <thread>

#include "cli/options.hpp"
#include "config/errors.hpp"
#include "experiment/out_folder.hpp"
#include "gripline/command.hpp"
#include "sweep/factor_statistics.hpp"
#include "sweep/keys.hpp"
#include "sweep/local_engine.hpp"
#include "sweep/merge.hpp"
#include "sweep/slurm_engine.hpp"
#include "sweep/store.hpp"
#include "sweep/task.hpp"
#include "util/disk.hpp"
#include "util/machine.hpp"
#include "util/numbers.hpp"
#include "util/progress.hpp"
#include "util/signals.hpp"
#include "util/temporary_folder.hpp"

namespace gripline::tools {
namespace fs = std::filesystem;
namespace {

using Clock = std::chrono::steady_clock;

int jobs_of(const SweepWork& work) {
  return work.jobs > 0 ? work.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// Folders of the manifest that are here: nodes have plugins in places of their own.
Registry registry_for(const std::vector<std::string>& plugin_dirs) {
  Words here;
  std::error_code failed;
  for (const std::string& dir : plugin_dirs)
    if (fs::is_directory(dir, failed)) here.push_back(dir);
  return open_registry(here);
}

/// A folder of this process's own.
std::string own_folder() { return "gripline." + this_machine() + "." + std::to_string(getpid()); }

struct Counts {
  std::size_t runs = 0, finished = 0, broken = 0;
  std::size_t missing() const { return runs - finished - broken; }
};

Counts count_records(const fs::path& out, const sweep::Sweep& sweep) {
  const sweep::KeyFile keys(out, sweep);
  const sweep::Store store(out);
  Counts counts;
  counts.runs = keys.size();
  for (std::size_t i = 0; i < counts.runs; ++i) {
    const std::string key = keys.key(i);
    if (store.has(key, false))
      ++counts.finished;
    else if (store.has(key, true))
      ++counts.broken;
  }
  return counts;
}

sweep::SlurmEngine slurm_of(const SweepWork& work) {
  sweep::SlurmOptions options;
  options.program = fs::read_symlink("/proc/self/exe");
  options.partition = work.partition;
  options.time = work.time;
  options.mem = work.mem;
  options.extra = work.sbatch;
  options.at_once = work.jobs;
  options.scratch = work.scratch;
  return sweep::SlurmEngine(std::move(options));
}

/// The batches that Slurm may still be working on.
bool slurm_is_active(const fs::path& out) {
  SweepWork work;
  work.out = out;
  sweep::SlurmEngine engine = slurm_of(work);
  for (const std::string& number : sweep::batches_in(out)) {
    const sweep::Submission submission = read_submission(sweep::read_batch(out, number));
    if (submission.engine == "slurm" && engine.status(submission).active()) return true;
  }
  return false;
}

void refuse_while_active(const fs::path& out) {
  if (slurm_is_active(out))
    throw InputError(out.string() + ": its jobs are not over; wait for them (gripline sweep status " + out.string() +
                     ") or end them (gripline sweep cancel " + out.string() + ")");
}

/// Jobs of earlier batches that Slurm holds for ever.
void end_leftovers(const SweepWork& work) {
  sweep::SlurmEngine engine = slurm_of(work);
  for (const std::string& number : sweep::batches_in(work.out)) {
    const sweep::Submission submission = read_submission(sweep::read_batch(work.out, number));
    if (submission.engine == "slurm" && engine.status(submission).stuck) engine.cancel(submission);
  }
}

/// Puts the numbers of runs without a record into a batch; none when there is nothing to do.
std::optional<sweep::Batch> batch_of_missing(const SweepWork& work, const sweep::Sweep& sweep, const Counts& counts) {
  const std::size_t left = counts.missing() + (work.resume ? counts.broken : 0);
  if (left == 0) return std::nullopt;
  const std::size_t own = work.engine == "slurm"
                              ? 50
                              : std::clamp<std::size_t>(left / (16 * static_cast<std::size_t>(jobs_of(work))), 1, 50);
  const sweep::KeyFile keys(work.out, sweep);
  const sweep::Store store(work.out);
  std::uint64_t at = 0;
  const auto next = [&](std::uint64_t& run) {
    while (at < keys.size() && store.has(keys.key(at), !work.resume)) ++at;
    run = at++;
    return run < keys.size();
  };
  return sweep::make_batch(work.out, next, work.chunk > 0 ? work.chunk : own, work.resume);
}

/// Tables, statistics and the report, and what they say. Gives the exit code.
int merge_and_tell(const fs::path& out, const sweep::Sweep& sweep) {
  sweep::Table table;
  CallbackProgress progress(std::cerr, "merge");
  const ProgressCallback tell = progress.callback();
  const sweep::MergeOutcome outcome = sweep::merge_records(
      out, sweep, table, [&](std::size_t done, std::size_t total) { tell(static_cast<double>(done), total, ""); });
  const sweep::Statistics statistics = sweep::analyse(table);
  sweep::write_statistics(out, sweep, outcome, table, statistics);
  progress.finish();
  sweep::print_statistics(std::cout, statistics);
  std::cout << outcome.finished << " of " << outcome.runs << " runs finished";
  if (outcome.broken > 0) std::cout << ", " << outcome.broken << " broke";
  if (outcome.missing > 0) std::cout << ", " << outcome.missing << " are missing";
  std::cout << "; " << duration_text(outcome.cpu_s) << " of CPU\nresults: " << out.string() << '\n';
  const bool reported = report_results(out);
  if (outcome.complete()) {  // what tasks left that were killed
    sweep::Store(out).remove_partial();
    disk().remove_all(out / "work");
  }
  if (outcome.missing > 0 || outcome.broken > 0)
    std::cerr << (out / "missing.csv").string() << " says which; gripline sweep --resume --out " << out.string()
              << " does them again\n";
  if (outcome.missing > 0) return try_again;
  return outcome.broken > 0 || !reported ? run_broke : good;
}

int run_local(const SweepWork& work, const sweep::Sweep& sweep, const Registry& registry, const sweep::Batch& batch) {
  const fs::path in_out = work.out / "work", scratch = (work.scratch.empty() ? in_out : work.scratch) / own_folder();
  disk().remove_all(in_out);  // of a sweep that was killed: the lock is ours
  sweep::LocalEngine engine(sweep.name, jobs_of(work), [&](std::size_t) -> sweep::TaskBody {
    auto worker = std::make_shared<sweep::Worker>(sweep, registry, batch.out, scratch / own_folder());
    return [worker](const sweep::Batch& b, std::size_t task, const std::function<void()>& done) {
      return worker->run(b, task, done);
    };
  });
  sweep::Submission submission;
  engine.submit(batch, submission, [&] { write_submission(batch, submission); });
  disk().remove_all(scratch);
  disk().remove_all(in_out);
  if (engine.interrupted()) std::cerr << "interrupted: what is finished is kept; the same command goes on from here\n";
  return engine.interrupted() ? try_again : good;
}

int run_slurm(const SweepWork& work, const sweep::Sweep& sweep, const sweep::Batch& batch) {
  sweep::SlurmEngine engine = slurm_of(work);
  sweep::Submission submission;
  engine.submit(batch, submission, [&] { write_submission(batch, submission); });
  std::cout << engine.plan(batch) << "\njobs:";
  for (const std::string& job : submission.jobs) std::cout << ' ' << job;
  std::cout << '\n' << std::flush;
  if (!work.wait) {
    std::cout << "gripline sweep status " << work.out.string() << " says how far they are\n";
    return good;
  }
  const StopSignal stop(StopSignal::Reaction::note);
  Progress progress(std::cerr, "slurm", batch.runs);
  const std::size_t before = count_records(batch.out, sweep).missing();
  for (sweep::EngineState state = engine.status(submission); state.active() && !StopSignal::seen();
       state = engine.status(submission)) {
    progress.advance(before - std::min(before, count_records(batch.out, sweep).missing()), state.message);
    for (int i = 0; i < 10 && !StopSignal::seen(); ++i) usleep(100'000);
  }
  if (StopSignal::seen()) {
    std::cerr << "the jobs go on without this program: gripline sweep status|cancel " << work.out.string() << '\n';
    return try_again;
  }
  progress.finish();
  return good;
}

int do_missing(const SweepWork& work, const sweep::Sweep& sweep, const Registry& registry) {
  const Counts counts = count_records(work.out, sweep);
  if (counts.finished + counts.broken > 0)
    std::cout << counts.finished + counts.broken << " of " << counts.runs << " runs were already there.\n";
  const std::optional<sweep::Batch> batch = batch_of_missing(work, sweep, counts);
  std::cout << std::flush;
  if (batch && work.engine == "slurm") {
    end_leftovers(work);
    const int code = run_slurm(work, sweep, *batch);
    if (code != good || !work.wait) return code;
  } else if (batch) {
    const int code = run_local(work, sweep, registry, *batch);
    if (code != good && count_records(work.out, sweep).finished == 0) return code;
  }
  return merge_and_tell(work.out, sweep);
}

/// How many values each factor has in the rows of a list; of other designs none.
std::vector<std::size_t> listed_values(const sweep::Design& design) {
  std::vector<std::set<std::string>> values(design.factors().size());
  for (std::size_t i = 0; design.kind() == sweep::Design::Kind::list && i < design.size(); ++i) {
    const std::vector<std::string> setting = design.setting(i);
    for (std::size_t f = 0; f < setting.size(); ++f) values[f].insert(setting[f]);
  }
  std::vector<std::size_t> counts;
  counts.reserve(values.size());
  for (const std::set<std::string>& of_factor : values) counts.push_back(of_factor.size());
  return counts;
}

void print_plan(const sweep::Sweep& sweep) {
  for (const sweep::Part& part : sweep.parts)
    std::cout << part.name << " (" << part.kind << "): " << sweep.design.size()
              << (sweep.design.size() == 1 ? " setting x " : " settings x ") << part.rows.size()
              << (part.rows.size() == 1 ? " row x " : " rows x ") << part.seeds.size()
              << (part.seeds.size() == 1 ? " seed\n" : " seeds\n");
  const std::vector<std::size_t> listed = listed_values(sweep.design);
  for (std::size_t f = 0; f < listed.size(); ++f) {
    const sweep::Factor& factor = sweep.design.factors()[f];
    std::cout << "  " << factor.pointer << ": ";
    if (listed[f] > 0) std::cout << listed[f] << (listed[f] == 1 ? " value" : " values") << " of the list";
    if (factor.range() && sweep.design.kind() == sweep::Design::Kind::latin)
      std::cout << factor.lo << ".." << factor.hi;
    for (std::size_t i = 0; i < factor.levels.size(); ++i) std::cout << (i > 0 ? ", " : "") << factor.levels[i];
    std::cout << '\n';
  }
}

std::string size_text(double bytes) {
  constexpr const char* units[] = {"B", "kB", "MB", "GB", "TB"};
  std::size_t unit = 0;
  for (; bytes >= 1000 && unit + 1 < std::size(units); ++unit) bytes /= 1000;
  return format("%.*f %s", bytes < 10 && unit > 0 ? 1 : 0, bytes, units[unit]);
}

}  // namespace

int plan_sweep(const sweep::Request& request, const SweepWork& work) {
  const Registry registry = open_registry(request.plugin_dirs);
  sweep::Sweep sweep = plan(request, registry);
  print_plan(sweep);
  const TemporaryFolder folder("sweep");
  const Clock::time_point begin = Clock::now();
  write_manifest(folder.path() / "plan", sweep, registry);
  const double planning = std::chrono::duration<double>(Clock::now() - begin).count();
  const sweep::KeyFile keys(folder.path() / "plan", sweep);
  const sweep::Store store(work.out);
  std::size_t there = 0;
  for (std::size_t i = 0; i < keys.size(); ++i) there += store.has(keys.key(i), true) ? 1 : 0;
  std::cout << "runs: " << sweep.size() << ", " << there << " of them already there, keys in "
            << duration_text(planning) << '\n';
  // One run, in the middle of the sweep, says what the others cost.
  sweep.keep_files = false;
  sweep::Worker worker(sweep, registry, folder.path() / "plan", folder.path() / "run");
  const Clock::time_point start = Clock::now();
  const sweep::Record record = worker.try_run(sweep.at(sweep.size() / 2));
  const double wall = std::chrono::duration<double>(Clock::now() - start).count();
  if (record.broken()) std::cout << "the run that was tried broke: " << escape_control(record.message) << '\n';
  const auto left = static_cast<double>(sweep.size() - there);
  constexpr double bytes_of_record = 4096 + 400;  // a block of the file system, and its row of the tables
  std::cout << "estimated time: " << duration_text(left * wall / jobs_of(work)) << " with " << jobs_of(work)
            << " at a time (one run took " << number_text(std::round(wall * 1000) / 1000)
            << " s; it was driven to know, and not kept)\nestimated disk: "
            << size_text(bytes_of_record * static_cast<double>(sweep.size()))
            << (request.keep_files ? " and the files of the runs" : "") << '\n';
  return good;
}

int start_sweep(const sweep::Request& request, const SweepWork& given) {
  SweepWork work = given;
  work.out = fs::absolute(given.out).lexically_normal();
  const Registry registry = open_registry(request.plugin_dirs);
  const sweep::Sweep sweep = plan(request, registry);
  sweep::require_sweep_folder(work.out);
  std::optional<OutLock> lock;
  lock.emplace(work.out);
  if (sweep::holds_sweep(work.out)) refuse_while_active(work.out);
  write_manifest(work.out, sweep, registry);
  print_plan(sweep);
  std::cout << "runs: " << sweep.size() << '\n';
  if (work.engine == "slurm") lock.reset();  // the merge job takes it
  return do_missing(work, sweep::read_manifest(work.out), registry);
}

int continue_sweep(const SweepWork& given) {
  SweepWork work = given;
  work.out = fs::absolute(given.out).lexically_normal();
  const sweep::Sweep sweep = sweep::read_manifest(work.out);
  std::optional<OutLock> lock;
  lock.emplace(work.out);
  refuse_while_active(work.out);
  if (work.engine == "slurm") lock.reset();
  fs::current_path(sweep.folder);  // relative files of assignments start there
  const Registry registry = registry_for(sweep.plugin_dirs);
  require_same_versions(sweep, registry);
  return do_missing(work, sweep, registry);
}

int sweep_merge(const fs::path& given) {
  const fs::path out = fs::absolute(given).lexically_normal();
  const sweep::Sweep sweep = sweep::read_manifest(out);
  const OutLock lock(out);
  return merge_and_tell(out, sweep);
}

int sweep_status(const fs::path& given) {
  const fs::path out = fs::absolute(given).lexically_normal();
  const sweep::Sweep sweep = sweep::read_manifest(out);
  const Counts counts = count_records(out, sweep);
  std::cout << sweep.name << ": " << counts.runs << " runs, " << counts.finished << " finished, " << counts.broken
            << " broke, " << counts.missing() << " missing\n";
  SweepWork work;
  work.out = out;
  sweep::SlurmEngine slurm = slurm_of(work);
  for (const std::string& number : sweep::batches_in(out)) {
    const sweep::Batch batch = sweep::read_batch(out, number);
    const sweep::Submission submission = read_submission(batch);
    std::cout << "batch " << number << ": " << batch.runs << " runs in " << batch.tasks() << " tasks, engine "
              << (submission.engine.empty() ? "none: it was never submitted" : submission.engine);
    if (submission.engine == "slurm") {
      const sweep::EngineState state = slurm.status(submission);
      std::cout << ", "
                << (state.known ? state.active() || state.stuck ? state.message : "over"
                                : "Slurm does not answer: " + state.message);
    }
    std::cout << '\n';
    for (const std::string& line : sweep::task_troubles(batch)) std::cout << "  " << escape_control(line) << '\n';
  }
  return counts.missing() > 0 ? try_again : counts.broken > 0 ? run_broke : good;
}

int sweep_cancel(const fs::path& given) {
  const fs::path out = fs::absolute(given).lexically_normal();
  const sweep::Sweep sweep = sweep::read_manifest(out);
  SweepWork work;
  work.out = out;
  sweep::SlurmEngine slurm = slurm_of(work);
  for (const std::string& number : sweep::batches_in(out)) {
    const sweep::Submission submission = read_submission(sweep::read_batch(out, number));
    if (submission.engine != "slurm") continue;
    slurm.cancel(submission);
    for (int i = 0; i < 300 && slurm.status(submission).active(); ++i) usleep(100'000);
  }
  // Whoever holds the lock is at work here; without it there is nobody.
  bool told = false;
  for (int i = 0; i < 100; ++i) {
    std::optional<OutLock> lock;
    try {
      lock.emplace(out);
    } catch (const InputError&) {
      const std::optional<pid_t> holder = told ? std::nullopt : OutLock::holder_here(out);
      if (holder) told = kill(*holder, SIGTERM) == 0;
      usleep(100'000);
      continue;
    }
    sweep::Store(out).remove_partial();
    disk().remove_all(out / "work");
    const Counts counts = count_records(out, sweep);
    std::cout << "cancelled: " << counts.finished << " of " << counts.runs << " runs are finished and kept\n";
    return good;
  }
  throw InputError(out.string() + ": another gripline is writing there and does not end" +
                   (told ? "" : "; its process is not on this machine"));
}

int sweep_task(const fs::path& given, const std::string& number, const std::string& task_text) {
  const fs::path out = fs::absolute(given).lexically_normal();
  std::size_t task = 0;
  const auto [stop, error] = std::from_chars(task_text.data(), task_text.data() + task_text.size(), task);
  if (error != std::errc() || stop != task_text.data() + task_text.size())
    throw InputError("task " + task_text + ": expected a whole number");
  const StopSignal signals(StopSignal::Reaction::note);
  const sweep::Batch batch = sweep::read_batch(out, number);
  sweep::TaskNote note(batch, task);
  const char* const chosen = std::getenv("GRIPLINE_SCRATCH");
  const fs::path scratch = fs::absolute(chosen != nullptr ? chosen : (out / "work").c_str()) / own_folder();
  int code = sweep::task_again;
  try {
    const sweep::Sweep sweep = sweep::read_manifest(out);
    fs::current_path(sweep.folder);
    const Registry registry = registry_for(sweep.plugin_dirs);
    require_same_versions(sweep, registry);
    sweep::Worker worker(sweep, registry, out, scratch);
    code = worker.run(batch, task, [] {});
    note.end(code, code == sweep::task_refused ? "inputs are no longer those of the manifest" : "");
  } catch (const PluginError& e) {
    note.end(code = sweep::task_refused, e.what());
    std::cerr << escape_control(e.what()) << '\n';
  } catch (const InputError& e) {
    note.end(code = sweep::task_refused, e.what());
    std::cerr << e.what() << '\n';
  } catch (const std::exception& e) {
    note.end(code, e.what());
    std::cerr << escape_control(e.what()) << '\n';
  }
  disk().remove_all(scratch);
  // A scheduler that repeats what ends with 75 must come to an end.
  constexpr int most_restarts = 3;
  const char* const restarts = std::getenv("SLURM_RESTART_COUNT");
  return code == sweep::task_again && restarts != nullptr && std::atoi(restarts) >= most_restarts ? run_broke : code;
}

}  // namespace gripline::tools
