#include "sweep/slurm_engine.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <sstream>
#include <stdexcept>

#include "config/errors.hpp"
#include "util/pipe.hpp"
#include "util/started_program.hpp"
#include "util/whole_file.hpp"

namespace gripline::sweep {
namespace fs = std::filesystem;
namespace {

struct CommandResult {
  int code = -1;       // exit code; 127: not installed
  std::string output;  // of both streams
};

/// Runs one of Slurm's commands and collects its output.
CommandResult run_command(const std::vector<std::string>& words) {
  Pipe output;
  const int into = output.write.number();
  StartedProgram program(
      words, {.handles = {{STDOUT_FILENO, into}, {STDERR_FILENO, into}}, .usual_signals = {SIGINT, SIGTERM, SIGPIPE}});
  output.write.close();
  CommandResult result;
  char chunk[4096];
  for (;;) {
    const ssize_t got = read(output.read.number(), chunk, sizeof chunk);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    result.output.append(chunk, static_cast<std::size_t>(got));
  }
  output.read.close();
  result.code = program.exit_code().value_or(-1);
  while (result.output.ends_with('\n')) result.output.pop_back();
  return result;
}

std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// Runs sbatch with these arguments; returns the job's number.
std::string submit_job(const std::vector<std::string>& words) {
  const CommandResult result = run_command(words);
  if (result.code == 127) throw std::runtime_error("sbatch is not installed here: nothing was submitted");
  if (result.code != 0) throw std::runtime_error("sbatch refused: " + result.output);
  std::istringstream lines(result.output);
  std::string job;
  for (std::string line; std::getline(lines, line);)
    if (!line.empty() && std::isdigit(static_cast<unsigned char>(line.front())) != 0) job = line;
  job = job.substr(0, job.find(';'));  // with several clusters "number;cluster"
  if (job.empty()) throw std::runtime_error("sbatch said no job's number: " + result.output);
  return job;
}

/// Slurm's MaxArraySize less one, the largest index of an array job; its default where Slurm does not say.
std::size_t max_array_tasks() {
  constexpr std::size_t usual = 1001;
  const CommandResult result = run_command({"scontrol", "show", "config"});
  const std::size_t at = result.output.find("MaxArraySize");
  if (result.code != 0 || at == std::string::npos) return usual - 1;
  const std::size_t equals = result.output.find('=', at);
  std::size_t size = usual;
  std::istringstream(result.output.substr(equals + 1, 20)) >> size;
  return std::max<std::size_t>(size, 2) - 1;
}

std::string joined(const std::vector<std::string>& words, char between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : std::string(1, between)) + word;
  return text;
}

}  // namespace

std::string SlurmEngine::plan(const Batch& batch) const {
  return std::to_string(batch.tasks()) + " Slurm tasks of at most " + std::to_string(batch.chunk) +
         " runs, and a merge job after them";
}

std::vector<std::string> SlurmEngine::common_arguments(const Batch& batch) const {
  std::vector<std::string> words = {"sbatch", "--parsable", "--chdir=" + batch.out.string()};
  if (!options_.partition.empty()) words.push_back("--partition=" + options_.partition);
  if (!options_.time.empty()) words.push_back("--time=" + options_.time);
  if (!options_.mem.empty()) words.push_back("--mem=" + options_.mem);
  words.insert(words.end(), options_.extra.begin(), options_.extra.end());
  return words;
}

void SlurmEngine::submit(const Batch& batch, Submission& submission, const std::function<void()>& keep) {
  submission.engine = "slurm";
  const std::string number = batch.folder.filename().string();
  std::error_code failed;
  fs::create_directories(batch.folder / "log", failed);
  std::string script = "#!/bin/sh\n";
  if (!options_.scratch.empty()) script += "export GRIPLINE_SCRATCH=" + quoted(options_.scratch.string()) + "\n";
  // exec, so that Slurm signals and waits for the task itself.
  write_file(batch.folder / "task.sh", script + "exec " + quoted(options_.program.string()) + " sweep task " +
                                           quoted(batch.out.string()) + " " + number +
                                           " $((SLURM_ARRAY_TASK_ID + $1))\n");
  // Exit code 75 would requeue the merge on clusters whose RequeueExit lists it.
  write_file(batch.folder / "merge.sh", "#!/bin/sh\n" + quoted(options_.program.string()) + " sweep merge " +
                                            quoted(batch.out.string()) +
                                            "\ncode=$?\n[ $code = 75 ] && code=1\nexit $code\n");
  const std::size_t most = max_array_tasks();
  for (std::size_t first = 0; first < batch.tasks(); first += most) {
    const std::size_t last = std::min(batch.tasks(), first + most) - first - 1;
    std::string array = "--array=0-" + std::to_string(last);
    if (options_.at_once > 0) array += "%" + std::to_string(options_.at_once);
    std::vector<std::string> words = common_arguments(batch);
    for (const std::string& word :
         {array, std::string("--job-name=gripline-sweep"), "--output=" + (batch.folder / "log/%a.%A.txt").string(),
          (batch.folder / "task.sh").string(), std::to_string(first)})
      words.push_back(word);
    submission.jobs.push_back(submit_job(words));
    keep();
  }
  std::vector<std::string> words = common_arguments(batch);
  for (const std::string& word :
       {"--dependency=afterany:" + joined(submission.jobs, ':'), std::string("--job-name=gripline-merge"),
        "--output=" + (batch.folder / "log/merge.txt").string(), (batch.folder / "merge.sh").string()})
    words.push_back(word);
  submission.jobs.push_back(submit_job(words));
  keep();
}

EngineState SlurmEngine::status(const Submission& submission) {
  EngineState state;
  if (submission.jobs.empty()) return state;
  // All jobs of this user, because squeue fails when asked for a job that Slurm has forgotten.
  const CommandResult result = run_command({"squeue", "--me", "--noheader", "--array", "--format=%F %T %r"});
  if (result.code != 0) {
    state.known = result.code == 127;  // without Slurm there are no jobs
    state.message = result.output;
    return state;
  }
  std::istringstream lines(result.output);
  std::string reason;
  std::size_t stopped = 0, following = 0, next = 0;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream cells(line);
    std::string job, what, why;
    cells >> job >> what;
    std::getline(cells >> std::ws, why);
    if (std::find(submission.jobs.begin(), submission.jobs.end(), job) == submission.jobs.end()) continue;
    if (what != "PENDING") {
      ++state.running;
      continue;
    }
    ++state.waiting;
    const bool held = why.find("held") != std::string::npos || why.find("Held") != std::string::npos;
    if (held) reason = why;
    (held ? stopped : why == "Dependency" ? following : next) += 1;
  }
  // Slurm holds a task whose node failed while the task was being started.
  state.stuck = stopped > 0 && state.running + next == 0;
  state.message = state.stuck
                      ? std::to_string(stopped) + " held by Slurm (" + reason + ")"
                      : std::to_string(state.running) + " running, " + std::to_string(state.waiting) + " waiting";
  return state;
}

void SlurmEngine::cancel(const Submission& submission) {
  if (submission.jobs.empty()) return;
  std::vector<std::string> words = {"scancel", "--quiet"};
  // The merge job first: the end of the others would start it.
  words.insert(words.end(), submission.jobs.rbegin(), submission.jobs.rend());
  const CommandResult result = run_command(words);
  if (result.code == 127) throw std::runtime_error("scancel is not installed here");
}

}  // namespace gripline::sweep
