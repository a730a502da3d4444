// Engines do the runs of a sweep: one small interface, so that another batch system is one more file.
//
// A batch is a list of run numbers in a file, cut into tasks of `chunk` runs. An engine has run_task() called for every
// task, on some machine, at least once. It may lose tasks, do them twice or late: records are named by a hash of their
// inputs and written whole, so that missing ones are found and repetitions do no harm.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace gripline::sweep {

/// OUT/batches/<number>/: `runs` lists the numbers, `submission.json` says where they went, `task-<n>.json` how far.
struct Batch {
  std::filesystem::path out, folder;  // absolute
  std::size_t runs = 0, chunk = 1;
  bool repeat_broken = false;  // runs that broke are done again
  std::size_t tasks() const { return (runs + chunk - 1) / chunk; }
};

/// What an engine must know to find its jobs again, kept in submission.json.
struct Submission {
  std::string engine;
  std::vector<std::string> jobs;  // its own names of them
};

struct EngineState {
  bool known = true;                     // whether the engine answered
  std::size_t waiting = 0, running = 0;  // tasks
  std::string message;                   // what else the user should know
  bool stuck = false;  // what waits will never run unless somebody acts: resuming ends it and submits what is missing
  bool active() const { return !known || (waiting + running > 0 && !stuck); }
};

class Engine {
 public:
  virtual ~Engine() = default;
  /// What submit() would do, in a line or more for people.
  virtual std::string plan(const Batch& batch) const = 0;
  /// Starts a batch; engines that work here return when it is over. `submission` is filled in as jobs are made, and
  /// `keep` is called after each, so that no job is lost sight of. Throws std::runtime_error when it cannot be started.
  virtual void submit(const Batch& batch, Submission& submission, const std::function<void()>& keep) = 0;
};

/// How a task ended: its exit code.
enum TaskExit : int {
  task_done = 0,
  task_refused = 3,  // other versions here: an error of this place
  task_broke = 4,    // a run broke
  task_again = 75,   // EX_TEMPFAIL of sysexits.h: what is missing may be had by another try
};

/// A task's work, in this process; `done` is called after every run. Gives a TaskExit.
using TaskBody = std::function<int(const Batch& batch, std::size_t task, const std::function<void()>& done)>;

/// Makes OUT/batches/<next number>/ with the runs that `next_run` gives until it says false; at least one. The folder
/// appears when it is complete.
Batch make_batch(const std::filesystem::path& out, const std::function<bool(std::uint64_t&)>& next_run,
                 std::size_t chunk, bool repeat_broken);
Batch read_batch(const std::filesystem::path& out, const std::string& number);
/// The numbers of batches that were made, ascending; what is half made is none of them.
std::vector<std::string> batches_in(const std::filesystem::path& out);
/// Run numbers of a task.
std::vector<std::uint64_t> runs_of(const Batch& batch, std::size_t task);

/// A task's own record in task-<n>.json, for clusters that keep none: where and when it began,
/// and how it ended.
class TaskNote {
 public:
  TaskNote(const Batch& batch, std::size_t task);
  void end(int code, const std::string& message);

 private:
  void write(int code, const std::string& message) const;
  std::filesystem::path file_;
  std::string node_, began_;
};
/// A line for each task that began and did not end well, the first dozen.
std::vector<std::string> task_troubles(const Batch& batch);

void write_submission(const Batch& batch, const Submission& submission);
/// Without an engine when none was written.
Submission read_submission(const Batch& batch);

}  // namespace gripline::sweep
