#include "limit/limit_table.hpp"

#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <map>
#include <optional>
#include <stdexcept>

#include "config/files.hpp"
#include "config/hash.hpp"
#include "config/json_file.hpp"
#include "util/child_process.hpp"
#include "util/csv_writer.hpp"
#include "util/signals.hpp"

namespace gripline {
namespace fs = std::filesystem;
namespace {

constexpr const char* version = "limit 4 ";  // of the program that is solved

fs::path file_of(const fs::path& folder, const LimitRequest& request, const LapCase& of) {
  const std::string all =
      version + request.key + " " + number_text(of.factor) + (of.body ? " body" : "") + (of.patches ? " patches" : "");
  return folder / ("limit-" + sha256_hex(all).substr(0, 32) + ".json");
}

void write_lap(const fs::path& file, const LapLimit& lap) {
  Node node = Node::empty_object();
  node.set("factor", Node(lap.factor));
  node.set("body", Node(lap.body));
  node.set("patches", Node(lap.patches));
  node.set("lap_s", Node(lap.lap_s));
  node.set("error_s", Node(lap.error_s));
  node.set("nodes", Node(static_cast<double>(lap.nodes)));
  write_file(file, to_json_text(node));
}

/// What a process left: a lap, or the reason why there is none as "message"; empty when it left nothing.
std::optional<LapLimit> read_lap(const fs::path& file, std::string* message) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return std::nullopt;
  try {
    const Node node = parse_file(file);
    if (const Node* const why = node.find("message"); why != nullptr && why->is_text()) {
      if (message != nullptr) *message = why->text();
      return std::nullopt;
    }
    const auto number = [&](const char* key) { return node.find(key)->number(); };
    const auto flag = [&](const char* key) { return node.find(key)->boolean(); };
    return LapLimit{{number("factor"), flag("body"), flag("patches")},
                    number("lap_s"),
                    number("error_s"),
                    static_cast<int>(number("nodes"))};
  } catch (const std::exception&) {
    return std::nullopt;  // half written: as if absent
  }
}

/// A folder of this process's own, gone afterwards.
class ScratchFolder {
 public:
  ScratchFolder() : path_(fs::temp_directory_path() / ("gripline-limit-" + std::to_string(getpid()))) {
    fs::create_directories(path_);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

[[noreturn]] void child(const WorldSpec& spec, const LapCase& of, const fs::path& file, pid_t parent) {
  std::signal(SIGINT, SIG_IGN);  // the parent decides
  std::signal(SIGTERM, SIG_DFL);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  end_at_exit();
  try {
    write_lap(file, find_lap_limit(spec, of));
    _exit(0);
  } catch (const std::exception& e) {
    Node node = Node::empty_object();
    node.set("message", Node(std::string(e.what())));
    try {
      write_file(file, to_json_text(node));
    } catch (const std::exception&) {
    }
  }
  _exit(1);
}

struct Job {
  LapCase of;
  fs::path scratch, kept;  // where its process writes, where the result is kept (may be empty)
};

/// The job of each process that runs. Those that run in the end, as after an error, are ended.
class Children {
 public:
  Children() = default;
  ~Children() {
    for (const auto& [pid, job] : running) kill(pid, SIGTERM);
    for (const auto& [pid, job] : running) wait_for_end(pid);
  }
  Children(const Children&) = delete;
  Children& operator=(const Children&) = delete;

  std::map<pid_t, std::size_t> running;
};

/// Runs all jobs; throws when they are interrupted.
void run_jobs(const WorldSpec& spec, const std::vector<Job>& jobs, int at_once, std::size_t done, std::size_t total,
              const std::function<void(std::size_t, std::size_t)>& progress) {
  const StopSignal stop(StopSignal::Reaction::note);
  Children children;
  auto& running = children.running;
  std::size_t next = 0;
  while ((next < jobs.size() || !running.empty()) && !StopSignal::seen()) {
    if (next < jobs.size() && running.size() < static_cast<std::size_t>(at_once)) {
      const pid_t parent = getpid(), pid = fork_process();
      if (pid == 0) child(spec, jobs[next].of, jobs[next].scratch, parent);
      running[pid] = next++;
      continue;
    }
    done += std::erase_if(running, [](const auto& one) { return collect_if_ended(one.first).has_value(); });
    progress(done, total);
    usleep(50'000);
  }
  if (StopSignal::seen()) throw std::runtime_error("interrupted; finished laps are kept, the same command goes on");
}

}  // namespace

std::vector<LapLimit> compute_limits(const WorldSpec& spec, const LimitRequest& request,
                                     const std::function<void(std::size_t, std::size_t)>& progress) {
  const ScratchFolder scratch;
  std::vector<double> factors = request.factors;
  std::sort(factors.begin(), factors.end());
  std::vector<Job> all, open;
  for (const bool body : {false, true}) {
    if (body && !request.body) continue;
    for (const double factor : factors) {
      const LapCase of{factor, body, request.patches};
      all.push_back({of, file_of(scratch.path(), request, of),
                     request.cache.empty() ? fs::path() : file_of(request.cache, request, of)});
    }
  }
  for (const Job& job : all)
    if (job.kept.empty() || !read_lap(job.kept, nullptr)) open.push_back(job);
  std::exception_ptr interrupted;
  try {
    run_jobs(spec, open, request.jobs, all.size() - open.size(), all.size(), progress);
  } catch (const std::runtime_error&) {
    interrupted = std::current_exception();
  }
  std::error_code ignored;
  if (!request.cache.empty()) fs::create_directories(request.cache, ignored);
  std::vector<LapLimit> limits;
  std::string message;
  for (const Job& job : all) {
    std::string why = "its process left no result";
    std::optional<LapLimit> lap = read_lap(job.scratch, &why);
    if (lap && !job.kept.empty()) fs::copy_file(job.scratch, job.kept, fs::copy_options::overwrite_existing, ignored);
    if (!lap && !job.kept.empty()) lap = read_lap(job.kept, nullptr);
    if (lap)
      limits.push_back(*lap);
    else if (message.empty())
      message = "factor " + number_text(job.of.factor) + (job.of.body ? ", whole body: " : ": ") + why;
  }
  if (interrupted) std::rethrow_exception(interrupted);
  if (!message.empty()) throw std::runtime_error(message);
  return limits;
}

void write_limits(const fs::path& file, const std::vector<LapLimit>& limits) {
  std::string text;
  const bool patches = std::any_of(limits.begin(), limits.end(), [](const LapLimit& lap) { return lap.patches; });
  CsvWriter csv(text, patches ? "factor,lap_s,error_s,body,patches" : "factor,lap_s,error_s,body");
  for (const LapLimit& lap : limits) {
    csv << lap.factor << lap.lap_s << lap.error_s << (lap.body ? 1 : 0);
    if (patches) csv << (lap.patches ? 1 : 0);
    csv.end_row();
  }
  write_file(file, text);
}

}  // namespace gripline
