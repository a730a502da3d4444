#include "sweep/task.hpp"

#include <cerrno>
#include <iostream>

#include "config/errors.hpp"
#include "util/disk.hpp"
#include "util/signals.hpp"

namespace gripline::sweep {
namespace fs = std::filesystem;

Worker::Worker(const Sweep& sweep, const Registry& registry, fs::path out, fs::path scratch)
    : sweep_(sweep),
      registry_(registry),
      out_(std::move(out)),
      scratch_(std::move(scratch)),
      keys_(sweep, registry),
      planned_(out_, sweep),
      store_(out_),
      runner_([this](const RunAt& run) { return make(run); }) {}

/// What a run wrote is kept under its key, or removed.
void Worker::settle_files(const fs::path& folder, const std::string& key) const {
  if (folder.empty()) return;
  if (!sweep_.keep_files || key.empty()) return disk().remove_all(folder);
  const fs::path kept = out_ / "files" / key.substr(0, 2) / key;
  disk().make_folders(kept.parent_path());
  disk().remove_all(kept);
  if (disk().rename(folder, kept)) return;
  if (errno != EXDEV) fail_with_errno("cannot write " + kept.string());
  const fs::path aside = kept.parent_path() / ("." + key + ".partial");
  disk().remove_all(aside);
  fs::copy(folder, aside, fs::copy_options::recursive);
  disk().rename(aside, kept);
  disk().remove_all(folder);
}

Attempt Worker::make(const RunAt& run) {
  const Part& part = sweep_.parts[run.part];
  const SweptKind& kind = kind_named(part.kind);
  const RunLimits limits{sweep_.timeout_s, sweep_.memory_mb};
  if (kind.run != nullptr) {
    const fs::path folder = scratch_ / "run";
    disk().remove_all(folder);
    return run_other(part.file, kind, keys_.trees().run_tree(run, {sweep_.row_of(run)}), registry_, folder, limits);
  }
  if (races_ == nullptr || part_ != run.part || setting_ != run.setting) {
    races_ = std::make_unique<RaceRuns>(part.file, keys_.trees().run_tree(run, part.rows), registry_);
    part_ = run.part;
    setting_ = run.setting;
  }
  return races_->run(sweep_.row_of(run), run.seed, scratch_, limits, keys_.hashes());
}

Record Worker::try_run(const RunAt& run) {
  const Attempt attempt = make(run);
  settle_files(attempt.files, "");
  return attempt.record;
}

/// Gives a TaskExit.
int Worker::keep(Attempt attempt, std::size_t index, const std::string& key) const {
  Record& record = attempt.record;
  record.key = key;
  settle_files(attempt.files, attempt.cut_off ? "" : key);
  if (attempt.cut_off) {
    std::cerr << "run " << index << ": " << escape_control(record.message) << '\n';
    store_.note_missing(key, record.message);
    return task_again;
  }
  store_.write(record);
  return record.broken() ? task_broke : task_done;
}

int Worker::run(const Batch& batch, std::size_t task, const std::function<void()>& done) {
  int code = task_done;
  const auto refuse = [](std::uint64_t index) {
    std::cerr << "run " << index
              << ": experiment, files or plugins are no longer those that the sweep was planned with; plan it again\n";
    return task_refused;
  };
  for (const std::uint64_t index : runs_of(batch, task)) {
    if (index >= sweep_.size()) throw InputError(batch.folder.string() + " belongs to another sweep");
    const std::string planned = planned_.key(index);
    if (!store_.has(planned, !batch.repeat_broken)) {
      const RunAt run = sweep_.at(index);
      if (keys_.key(run) != planned) return refuse(index);
      Attempt attempt = runner_(run);
      if (attempt.interrupted) return task_again;
      // The run has read its files after they were hashed.
      if (!keys_.files_unchanged()) return refuse(index);
      const int end = keep(std::move(attempt), index, planned);
      if (end == task_again || code == task_done) code = end;
    }
    done();
    if (StopSignal::seen()) return task_again;
  }
  return code;
}

}  // namespace gripline::sweep
