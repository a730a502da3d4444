#include "experiment/run_result.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "config/errors.hpp"
#include "config/files.hpp"
#include "config/hash.hpp"
#include "config/json_file.hpp"
#include "race/run_files.hpp"
#include "util/csv.hpp"
#include "util/file_hashes.hpp"
#include "util/statistics.hpp"
#include "util/whole_file.hpp"

namespace gripline {
namespace fs = std::filesystem;
namespace {

Node numbers(const std::vector<double>& values) {
  Node::Array array;
  for (const double value : values) array.emplace_back(value);
  return Node(std::move(array));
}

std::vector<double> read_array(const Node& node, std::string_view key) {
  std::vector<double> out;
  if (const Node* array = node.find(key); array != nullptr && array->is_array())
    for (const Node& one : array->array()) out.push_back(one.is_number() ? one.number() : NAN);
  return out;
}
std::optional<double> read_maybe(const Node& node, std::string_view key) {
  const Node* const value = node.find(key);
  if (value == nullptr || !value->is_number()) return std::nullopt;
  return value->number();
}
/// Throws std::bad_optional_access where there is none: a missing number is no 0, which may be the best that there is.
double read_value(const Node& node, std::string_view key) { return read_maybe(node, key).value(); }
std::string read_string(const Node& node, std::string_view key) {
  const Node* const value = node.find(key);
  return value != nullptr && value->is_text() ? value->text() : "";
}

Status status_of(std::string_view name) {
  for (const Status status : {Status::finished, Status::crashed, Status::stuck, Status::timeout, Status::plugin_error})
    if (status_name(status) == name) return status;
  return Status::error;
}

RunTiming read_timing(const std::filesystem::path& folder) {
  RunTiming timing;
  const CsvTable table = read_csv(folder / run_files::timing);
  if (table.rows() == 0) return timing;
  const std::vector<double> solve = table.column("solve_ms");
  timing.solve_ms_median = nearest_rank_quantile(solve, 0.5);
  timing.solve_ms_p95 = nearest_rank_quantile(solve, 0.95);
  timing.solve_ms_p99 = nearest_rank_quantile(solve, 0.99);
  timing.update_ms_median = nearest_rank_quantile(table.column("update_ms"), 0.5);
  timing.cpu_s = table.column("cpu_s").back();
  return timing;
}

/// The files whose hashes are in the summary. Not log.txt: plugins write to it until the process ends.
std::vector<std::string> files_of_run(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder, failed)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_regular_file(failed) || name.ends_with(".partial")) continue;
    if (name != run_files::summary && name != run_files::log && name != run_files::timing &&
        name != run_files::timing_hash)
      names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// SHA-256 of a file as it is; empty when it cannot be read.
std::string hash_of(const fs::path& file) {
  static FileHashes hashes;
  return hashes.now(file);
}

/// As `sha256sum` writes it; empty when the file cannot be read.
std::string hash_line(const fs::path& file) {
  const std::string hash = hash_of(file);
  return hash.empty() ? hash : hash + "  " + file.filename().string() + "\n";
}

/// The first line of timing.sha256, which `sha256sum --check` skips. Not in summary.json: the same run gives the same
/// summary, however many are driven at a time.
constexpr std::string_view alone_line = "# alone: no other run was driven at the same time\n";
constexpr std::string_view beside_line = "# beside others: runs may have been driven at the same time\n";

/// Whether the run was alone, if timing.csv is still the one that timing.sha256 names. Times of which that is not
/// stated may be those of runs that shared the machine.
std::optional<bool> whole_times(const fs::path& folder) {
  const std::string line = hash_line(folder / run_files::timing);
  if (line.empty()) return std::nullopt;
  try {
    const std::string text = read_bytes(folder / run_files::timing_hash);
    for (const std::string_view first : {alone_line, beside_line, std::string_view()})
      if (text == std::string(first) + line) return first == alone_line;
  } catch (const InputError&) {
  }
  return std::nullopt;
}

/// The folder with the times of a run: its own, or that of the run which it equals.
fs::path folder_of_times(const fs::path& folder, const Node& summary) {
  const std::optional<double> seed = read_maybe(summary, "driven_as");
  return seed ? folder.parent_path() / std::to_string(static_cast<std::uint64_t>(*seed)) : folder;
}

/// What of the times is not as it was written. Only a run that broke before its first step may have none.
std::string damage_in_times(const fs::path& folder, const Node& summary) {
  const fs::path timed = folder_of_times(folder, summary);
  std::error_code ignored;
  const bool none =
      !fs::exists(timed / run_files::timing, ignored) && !fs::exists(timed / run_files::timing_hash, ignored);
  if ((none && read_value(summary, "steps") == 0.0) || whole_times(timed)) return {};
  std::string damage = run_files::timing;
  if (timed != folder) damage += " of seed " + timed.filename().string();
  return damage + (none ? " is missing" : " was changed or cut");
}

/// The hash that a summary holds of itself: of all the rest.
std::string hash_of_summary(Node node) {
  node.erase("sha256");
  return sha256_hex(content_text(node));
}

/// The numbers that every summary has. Others are null where they were not measured.
constexpr const char* required_numbers[] = {
    "seed", "violation_s", "violation_body_s", "plan_latency_s", "solver_failures", "steps", "simulated_s"};

/// What of a finished run is not as it was written; empty when all of it is.
std::string damage_in(const fs::path& folder, const Node& summary) {
  if (read_string(summary, "sha256") != hash_of_summary(summary)) return "summary.json was changed";
  const Node* const files = summary.find("files");
  if (files == nullptr || !files->is_object()) return "summary.json was changed";
  for (const char* const number : required_numbers)
    if (!read_maybe(summary, number)) return std::string(number) + " in summary.json is missing";
  for (const Member& file : files->object()) {
    const std::string hash = hash_of(folder / file.key);
    if (hash.empty()) return file.key + " is missing or cannot be read";
    if (!file.value.is_text() || hash != file.value.text()) return file.key + " was changed or cut";
  }
  return damage_in_times(folder, summary);
}

Node summary_node(const RunSummary& s, const std::string& key) {
  Node node = Node::empty_object();
  node.set("stack", Node(s.stack));
  node.set("seed", Node(static_cast<double>(s.seed)));
  node.set("status", Node(status_name(s.status)));
  node.set("message", Node(s.message));
  node.set("needs_truth", Node(s.needs_truth));
  node.set("lap_s", numbers(s.laps));
  node.set("lap_mean_factor", numbers(s.lap_mean_factors));
  node.set("mean_deviation_m", number_or_null(s.mean_deviation_m));
  node.set("hilly_deviation_m", number_or_null(s.hilly_deviation_m));
  node.set("violation_s", Node(s.violation_s));
  node.set("violation_body_s", Node(s.violation_body_s));
  node.set("violation_after_adapt_s", number_or_null(s.violation_after_adapt_s));
  node.set("violation_body_after_adapt_s", number_or_null(s.violation_body_after_adapt_s));
  node.set("mu_rmse", number_or_null(s.mu_rmse));
  node.set("mu_bias", number_or_null(s.mu_bias));
  node.set("mu_visited_rmse", number_or_null(s.mu_visited_rmse));
  node.set("plan_latency_s", Node(s.plan_latency_s));
  node.set("solver_failures", Node(static_cast<double>(s.solver_failures)));
  node.set("steps", Node(static_cast<double>(s.steps)));
  node.set("simulated_s", Node(s.simulated_s));
  node.set("key", Node(key));
  return node;
}

void finish_summary(const fs::path& folder, Node node, Node files) {
  node.set("files", std::move(files));
  node.set("sha256", Node(hash_of_summary(node)));
  write_file(folder / run_files::summary, to_json_text(node));
}

}  // namespace

void write_summary(const std::filesystem::path& folder, const RunSummary& s, const std::string& key, bool alone) {
  std::error_code ignored;
  if (fs::exists(folder / run_files::timing, ignored))
    write_file(folder / run_files::timing_hash,
               std::string(alone ? alone_line : beside_line) + hash_line(folder / run_files::timing));
  Node files = Node::empty_object();
  for (const std::string& name : files_of_run(folder)) files.set(name, Node(hash_of(folder / name)));
  finish_summary(folder, summary_node(s, key), std::move(files));
}

void write_copied_summary(const fs::path& folder, const RunResult& driven, std::uint64_t seed, const std::string& key) {
  RunSummary same = driven.summary;
  same.seed = seed;
  Node node = summary_node(same, key);
  node.set("driven_as", Node(static_cast<double>(driven.driven_as.value_or(driven.summary.seed))));
  node.set("drive", Node(driven.drive));
  finish_summary(folder, std::move(node), Node::empty_object());
}

std::optional<RunResult> read_result(const fs::path& folder, const std::string& key, std::string* damage) {
  if (damage != nullptr) damage->clear();
  const auto refuse = [&](const std::string& what) -> std::optional<RunResult> {
    if (damage != nullptr) *damage = what;
    return std::nullopt;
  };
  std::error_code ignored;
  if (!fs::exists(folder / run_files::summary, ignored)) return std::nullopt;
  try {
    const Node node = parse_file(folder / run_files::summary);
    if (!key.empty() && read_string(node, "key") != key) return std::nullopt;
    if (const std::string what = damage_in(folder, node); !what.empty()) return refuse(what);
    RunResult result;
    RunSummary& s = result.summary;
    s.stack = read_string(node, "stack");
    s.seed = static_cast<std::uint64_t>(read_value(node, "seed"));
    s.status = status_of(read_string(node, "status"));
    s.message = read_string(node, "message");
    const Node* const truth = node.find("needs_truth");
    s.needs_truth = truth != nullptr && truth->is_boolean() && truth->boolean();
    s.laps = read_array(node, "lap_s");
    s.lap_mean_factors = read_array(node, "lap_mean_factor");
    s.mean_deviation_m = read_maybe(node, "mean_deviation_m");
    s.hilly_deviation_m = read_maybe(node, "hilly_deviation_m");
    s.violation_s = read_value(node, "violation_s");
    s.violation_body_s = read_value(node, "violation_body_s");
    s.violation_after_adapt_s = read_maybe(node, "violation_after_adapt_s");
    s.violation_body_after_adapt_s = read_maybe(node, "violation_body_after_adapt_s");
    s.mu_rmse = read_maybe(node, "mu_rmse");
    s.mu_bias = read_maybe(node, "mu_bias");
    s.mu_visited_rmse = read_maybe(node, "mu_visited_rmse");
    s.plan_latency_s = read_value(node, "plan_latency_s");
    s.solver_failures = static_cast<std::int64_t>(read_value(node, "solver_failures"));
    s.steps = static_cast<std::int64_t>(read_value(node, "steps"));
    s.simulated_s = read_value(node, "simulated_s");
    if (const Node* const files = node.find("files"); files != nullptr)
      result.drive = read_string(*files, run_files::steps);
    if (const std::optional<double> seed = read_maybe(node, "driven_as")) {
      result.driven_as = static_cast<std::uint64_t>(*seed);
      result.drive = read_string(node, "drive");
    }
    const fs::path timed = folder_of_times(folder, node);
    if (fs::exists(timed / run_files::timing, ignored)) result.timing = read_timing(timed);
    result.timing.alone = whole_times(timed).value_or(false);
    return result;
  } catch (const std::exception&) {
    return refuse("summary.json or timing.csv cannot be read");
  }
}

}  // namespace gripline
