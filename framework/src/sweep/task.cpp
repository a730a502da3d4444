#include "sweep/task.hpp"

#include <cerrno>
#include <cstring>
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
      runner_([this](const RunAt& run, const std::string& key, bool& interrupted) {
        return race(run, key, interrupted);
      }) {}

/// What a run wrote is kept under its key, or removed.
void Worker::settle_files(const fs::path& folder, const std::string& key) const {
  if (!sweep_.keep_files || key.empty()) return disk().remove_all(folder);
  const fs::path kept = out_ / "files" / key.substr(0, 2) / key;
  disk().make_folders(kept.parent_path());
  disk().remove_all(kept);
  if (disk().rename(folder, kept)) return;
  if (errno != EXDEV) throw std::runtime_error("cannot write " + kept.string() + ": " + std::strerror(errno));
  const fs::path aside = kept.parent_path() / ("." + key + ".partial");
  disk().remove_all(aside);
  fs::copy(folder, aside, fs::copy_options::recursive);
  disk().rename(aside, kept);
  disk().remove_all(folder);
}

Record Worker::race(const RunAt& run, const std::string& key, bool& interrupted) {
  const Part& part = sweep_.parts[run.part];
  const RunLimits limits{sweep_.timeout_s, sweep_.memory_mb};
  if (part.kind != "race") {
    const fs::path folder = scratch_ / "run";
    disk().remove_all(folder);
    const Node tree = keys_.trees().run_tree(run, {sweep_.row_of(run)});
    Record record = run_other(part.file, part.kind, tree, registry_, folder, limits);
    settle_files(folder, key);
    return record;
  }
  if (races_ == nullptr || part_ != run.part || setting_ != run.setting) {
    races_ = std::make_unique<RaceRuns>(part.file, keys_.trees().run_tree(run, part.rows), registry_);
    part_ = run.part;
    setting_ = run.setting;
  }
  Record record = races_->run(sweep_.row_of(run), run.seed, scratch_, limits, keys_.hashes(), interrupted);
  if (!interrupted) settle_files(scratch_ / sweep_.row_of(run) / std::to_string(run.seed), key);
  return record;
}

Record Worker::try_run(const RunAt& run) {
  bool interrupted = false;
  return race(run, "", interrupted);
}

int Worker::run(const Batch& batch, std::size_t task, const std::function<void()>& done) {
  int code = task_done;
  for (const std::uint64_t index : runs_of(batch, task)) {
    if (index >= sweep_.size()) throw InputError(batch.folder.string() + " belongs to another sweep");
    const std::string planned = planned_.key(index);
    if (!store_.has(planned, !batch.repeat_broken)) {
      const RunAt run = sweep_.at(index);
      if (keys_.key(run) != planned) {
        std::cerr
            << "run " << index
            << ": experiment, files or plugins are no longer those that the sweep was planned with; plan it again\n";
        return task_refused;
      }
      bool interrupted = false;
      Record record = runner_(run, planned, interrupted);
      if (interrupted) return task_again;
      record.key = planned;
      if (may_be_retried(record)) {
        std::cerr << "run " << index << ": " << harmless(record.message) << '\n';
        code = task_again;
      } else {
        store_.write(record);
        if (record.broken() && code == task_done) code = task_broke;
      }
    }
    done();
    if (StopSignal::seen()) return task_again;
  }
  return code;
}

}  // namespace gripline::sweep
