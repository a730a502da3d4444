// Engine `local`: worker processes of this machine.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "sweep/engine.hpp"

namespace gripline::sweep {

/// Forks `jobs` workers that take tasks one after another. A worker that dies is replaced and its task taken up again,
/// three times at most; one that dies without a task is replaced three times at most. Ctrl-C and SIGTERM end workers
/// and their runs; so does the end of this process, however it comes. Where several worlds may be raced from one
/// process is the task's matter: a worker runs nothing itself.
class LocalEngine final : public Engine {
 public:
  /// Called in each worker, once, to open the sweep there; `worker` counts from 0.
  using Opener = std::function<TaskBody(std::size_t worker)>;
  LocalEngine(std::string name, int jobs, Opener open, bool show_progress = true)
      : name_(std::move(name)), jobs_(jobs), open_(std::move(open)), show_progress_(show_progress) {}

  std::string plan(const Batch& batch) const override;
  void submit(const Batch& batch, Submission& submission, const std::function<void()>& keep) override;
  /// Whether a signal ended the last batch.
  bool interrupted() const { return interrupted_; }

 private:
  std::string name_;
  int jobs_;
  Opener open_;
  bool show_progress_;
  bool interrupted_ = false;
};

}  // namespace gripline::sweep
