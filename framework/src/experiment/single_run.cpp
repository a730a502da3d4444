#include "experiment/single_run.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <iostream>
#include <new>
#include <optional>
#include <stdexcept>

#include "experiment/out_folder.hpp"
#include "experiment/run_folder.hpp"
#include "plugin/plugin_cache.hpp"
#include "race/assembly.hpp"
#include "race/run_files.hpp"
#include "util/child_process.hpp"
#include "util/disk.hpp"
#include "util/process_state.hpp"
#include "util/whole_file.hpp"

namespace gripline {
namespace fs = std::filesystem;
namespace {

/// Checks that a plugin removed none of the files that a race writes.
void require_files(const fs::path& folder) {
  std::error_code failed;
  for (const char* name : {run_files::config, run_files::steps, run_files::timing, run_files::replay, run_files::tyres})
    if (!fs::is_regular_file(folder / name, failed)) throw std::runtime_error(std::string(name) + " was taken away");
}

/// The values drawn for this run's seed, as draw.json.
void write_draw(const fs::path& folder, const Draw& draw) {
  Node node = Node::empty_object();
  for (const auto& [name, value] : {std::pair{"along_m", draw.along},
                                    {"across_m", draw.across},
                                    {"heading_rad", draw.heading},
                                    {"speed_mps", draw.speed},
                                    {"pace", draw.pace}})
    node.set(name, Node(value));
  write_file(folder / run_files::draw, to_json_text(node));
}

/// Standard input is empty from now on; output goes to `log`.
void redirect_streams(const fs::path& log) {
  if (const int empty = open("/dev/null", O_RDONLY); empty >= 0) {
    dup2(empty, STDIN_FILENO);
    if (empty > STDERR_FILENO) close(empty);
  }
  if (const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644); file >= 0) {
    dup2(file, STDOUT_FILENO);
    dup2(file, STDERR_FILENO);
    if (file > STDERR_FILENO) close(file);
  }
}

const StackSpec& stack_of(const RaceSpec& race, const RunId& id) {
  return *std::find_if(race.stacks.begin(), race.stacks.end(), [&](const auto& s) { return s.name == id.stack; });
}

/// What plugins compute before the first step is reported to `progress`, which may be null.
RaceSetup setup_of(const RunId& id, const fs::path& folder, RunProgress* progress) {
  RaceSetup setup;
  setup.seed = id.seed;
  setup.folder = folder;
  setup.cache_dir = plugin_cache_folder();
  if (progress != nullptr)
    setup.on_preparing = [progress](std::string_view what, double share) {
      progress->what.set(what);
      progress->preparing.store(share, std::memory_order_relaxed);
    };
  return setup;
}

}  // namespace

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

RunSummary run_here(const RaceSpec& race, const RunId& id, const std::string& key, const fs::path& out_folder,
                    RunProgress* progress, MachineUse use) {
  const fs::path out = fs::absolute(out_folder);  // a plugin may change the working folder
  const StackSpec& spec = stack_of(race, id);
  const fs::path partial = partial_folder(out, id);
  if (!disk().make_folders(partial)) fail_with_errno("cannot make " + partial.string());
  write_file(partial / run_files::config, to_json_text(race.run_tree(id.stack, id.seed)));
  RunSummary summary;
  summary.stack = id.stack;
  summary.seed = id.seed;
  summary.needs_truth = spec.needs_truth();
  bool kept = false;
  std::optional<ProcessState> state(std::in_place);
  const auto keep = [&] {
    const bool broken = summary.status == Status::plugin_error || summary.status == Status::error;
    keep_run(summary, broken ? broken_key(key) : key, out, use);
    kept = true;
    if (progress != nullptr) progress->kept.store(true);
  };
  try {
    WorldSpec world = race.world;
    StackSpec stack = spec;
    if (const std::optional<Draw> draw = perturb(race.perturb, id.seed, world, stack)) write_draw(partial, *draw);
    RaceAssembly assembly(world, stack, setup_of(id, partial, progress));
    if (progress != nullptr)
      assembly.simulation().on_progress(
          [progress](double share) { progress->fraction.store(share, std::memory_order_relaxed); });
    summary = assembly.run();
    state.reset();
    require_files(partial);
    keep();  // before plugins are destroyed, so that a destructor that fails loses no result
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

void run_as_process(const RaceSpec& race, const RunId& id, const std::string& key, const fs::path& out,
                    const ProcessSetup& setup, RunProgress* progress) {
  setpgid(0, 0);                  // processes that plugins start can be ended with this one
  std::signal(SIGINT, SIG_IGN);   // the parent ends this process
  std::signal(SIGXFSZ, SIG_IGN);  // a file beyond the size limit is then an error of write(), as on a full disk
  for (const int number : {SIGTERM, SIGCHLD, SIGTSTP, SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL})
    std::signal(number, SIG_DFL);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != setup.parent) _exit(run_lost);  // the parent ended before the line above
  OutLock::leave_to_parent();
  limit_data(setup.memory_mb);
  end_at_exit();
  last_call() = &progress->last;
  int code = 0;
  const auto note_disk = [&](const std::exception& e) {
    if (dynamic_cast<const DiskError*>(&e) != nullptr) progress->disk_refused.store(true);
  };
  try {
    std::string why;
    try {
      fs::create_directories(partial_folder(out, id));
      redirect_streams(partial_folder(out, id) / run_files::log);
      run_here(race, id, key, out, progress, setup.use);
    } catch (const std::bad_alloc&) {
      why = "ran out of memory" + describe_place(progress->last);
    } catch (const std::exception& e) {
      note_disk(e);
      why = e.what() + describe_place(progress->last) + plugins_of(race, id);
    }
    if (!progress->kept.load() && !why.empty()) {
      keep_broken_run(race, id, out, key, why);
      progress->kept.store(true);
    }
  } catch (const std::exception& e) {
    note_disk(e);
    code = run_lost;
  }
  std::cout.flush();
  _exit(code);
}

}  // namespace gripline
