#include "sweep/engine.hpp"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <stdexcept>

#include "config/errors.hpp"
#include "config/json_file.hpp"
#include "util/csv_writer.hpp"
#include "util/disk.hpp"
#include "util/machine.hpp"

namespace gripline::sweep {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t run_line = 9;  // eight digits and the end of the line
constexpr std::uint64_t largest_run_name = 99'999'999;

std::string run_text(std::uint64_t run) {
  char text[16];
  std::snprintf(text, sizeof text, "%08llu", static_cast<unsigned long long>(std::min(run, largest_run_name)));
  return text;
}

std::string now_text() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

constexpr int still_running = -1;
constexpr const char* submission_name = "submission.json";

/// Ascending.
std::vector<std::size_t> numbered_folders(const fs::path& folder) {
  std::vector<std::size_t> numbers;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder, failed)) {
    const std::string name = entry.path().filename().string();
    std::size_t number = 0;
    const auto [stop, error] = std::from_chars(name.data(), name.data() + name.size(), number);
    if (error == std::errc() && std::to_string(number) == name && entry.is_directory(failed)) numbers.push_back(number);
  }
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

}  // namespace

TaskNote::TaskNote(const Batch& batch, std::size_t task)
    : file_(batch.folder / ("task-" + std::to_string(task) + ".json")), began_(now_text()) {
  const char* const node = std::getenv("SLURMD_NODENAME");
  node_ = node != nullptr ? node : this_machine();
  write(still_running, "");
}

void TaskNote::end(int code, const std::string& message) { write(code, message); }

void TaskNote::write(int code, const std::string& message) const {
  Node node = Node::empty_object();
  node.set("node", Node(node_));
  node.set("process", Node(static_cast<double>(getpid())));
  node.set("began", Node(began_));
  node.set("now", Node(now_text()));
  node.set("code", Node(static_cast<double>(code)));
  node.set("message", Node(message));
  try {
    write_file(file_, to_json_text(node));
  } catch (const std::runtime_error&) {  // a note that is lost loses no result
  }
}

std::vector<std::string> task_troubles(const Batch& batch) {
  constexpr std::size_t most = 12;
  std::vector<std::string> lines;
  for (std::size_t task = 0; task < batch.tasks() && lines.size() < most; ++task) {
    const fs::path file = batch.folder / ("task-" + std::to_string(task) + ".json");
    std::error_code failed;
    if (!fs::exists(file, failed)) continue;
    try {
      const Node node = parse_file(file);
      const auto code = static_cast<int>(node.at("code").number());
      if (code == task_done) continue;
      std::string line = "task " + std::to_string(task) + " on " + node.at("node").text();
      line += code == still_running ? " began " + node.at("began").text() + " and has not ended"
                                    : " ended with " + number_text(code);
      if (!node.at("message").text().empty()) line += ": " + node.at("message").text();
      lines.push_back(std::move(line));
    } catch (const std::exception&) {
    }
  }
  return lines;
}

std::vector<std::string> batches_in(const fs::path& out) {
  std::vector<std::string> names;
  std::error_code failed;
  for (const std::size_t number : numbered_folders(out / "batches")) {
    const std::string name = std::to_string(number);
    // Older versions made the folder before what is in it: one that was killed meanwhile left a batch of no use.
    if (fs::exists(out / "batches" / name / submission_name, failed)) names.push_back(name);
  }
  return names;
}

Batch make_batch(const fs::path& out, const std::function<bool(std::uint64_t&)>& next_run, std::size_t chunk,
                 bool repeat_broken) {
  const std::vector<std::size_t> before = numbered_folders(out / "batches");
  const std::string number = std::to_string(before.empty() ? 1 : before.back() + 1);
  Batch batch;
  batch.out = fs::absolute(out).lexically_normal();
  batch.folder = batch.out / "batches" / ("." + number + ".partial");
  batch.chunk = std::max<std::size_t>(chunk, 1);
  batch.repeat_broken = repeat_broken;
  disk().remove_all(batch.folder);  // of a process that was killed
  if (!disk().make_folders(batch.folder)) fail_with_errno("cannot make " + batch.folder.string());
  std::uint64_t run = 0;
  if (!next_run(run)) throw std::logic_error("a batch without runs");
  CsvWriter file(batch.folder / "runs", run_text(run));
  ++batch.runs;
  while (next_run(run)) {
    file << std::string_view(run_text(run));
    file.end_row();
    ++batch.runs;
  }
  file.finish();
  write_submission(batch, {});
  const fs::path folder = batch.out / "batches" / number;
  if (!disk().rename(batch.folder, folder)) fail_with_errno("cannot write " + folder.string());
  (void)disk().sync_folder(folder.parent_path());  // a batch that a power failure takes away is planned again
  batch.folder = folder;
  return batch;
}

Batch read_batch(const fs::path& out, const std::string& number) {
  Batch batch;
  batch.out = fs::absolute(out).lexically_normal();
  batch.folder = batch.out / "batches" / number;
  std::error_code failed;
  batch.runs = static_cast<std::size_t>(fs::file_size(batch.folder / "runs", failed)) / run_line;
  if (failed) throw InputError(batch.folder.string() + " is no batch of a sweep");
  const Node node = parse_file(batch.folder / submission_name);
  const Node* const chunk = node.find("chunk");
  if (chunk == nullptr || !chunk->is_number() || chunk->number() < 1)
    throw InputError((batch.folder / submission_name).string() + " is not as gripline wrote it");
  batch.chunk = static_cast<std::size_t>(chunk->number());
  const Node* const repeat = node.find("repeat_broken");
  batch.repeat_broken = repeat != nullptr && repeat->is_boolean() && repeat->boolean();
  return batch;
}

std::vector<std::uint64_t> runs_of(const Batch& batch, std::size_t task) {
  const std::size_t first = task * batch.chunk, last = std::min(batch.runs, first + batch.chunk);
  if (first >= batch.runs)
    throw InputError("batch " + batch.folder.filename().string() + " has " + std::to_string(batch.tasks()) +
                     " tasks; there is no number " + std::to_string(task));
  std::ifstream in(batch.folder / "runs", std::ios::binary);
  in.seekg(static_cast<std::streamoff>(first * run_line));
  std::vector<std::uint64_t> runs;
  for (std::string line; runs.size() < last - first && std::getline(in, line);) {
    std::uint64_t run = 0;
    std::from_chars(line.data(), line.data() + line.size(), run);
    runs.push_back(run);
  }
  if (runs.size() != last - first) throw InputError((batch.folder / "runs").string() + " is shorter than its batch");
  return runs;
}

void write_submission(const Batch& batch, const Submission& submission) {
  Node node = Node::empty_object();
  node.set("chunk", Node(static_cast<double>(batch.chunk)));
  node.set("repeat_broken", Node(batch.repeat_broken));
  node.set("engine", Node(submission.engine));
  Node::Array jobs;
  for (const std::string& job : submission.jobs) jobs.emplace_back(job);
  node.set("jobs", Node(std::move(jobs)));
  write_file(batch.folder / submission_name, to_json_text(node));
}

Submission read_submission(const Batch& batch) {
  const Node node = parse_file(batch.folder / submission_name);
  Submission submission;
  if (const Node* engine = node.find("engine"); engine != nullptr && engine->is_text())
    submission.engine = engine->text();
  if (const Node* jobs = node.find("jobs"); jobs != nullptr && jobs->is_array())
    for (const Node& job : jobs->array()) submission.jobs.push_back(job.text());
  return submission;
}

}  // namespace gripline::sweep
