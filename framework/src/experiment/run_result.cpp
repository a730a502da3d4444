#include "experiment/run_result.hpp"

#include <cmath>

#include "config/json_file.hpp"
#include "util/csv.hpp"
#include "util/csv_writer.hpp"
#include "util/statistics.hpp"

namespace gripline {
namespace {

Node number_or_null(const std::optional<double>& number) { return number ? Node(*number) : Node::null(); }

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
double read_value(const Node& node, std::string_view key) {
  const Node* const value = node.find(key);
  return value != nullptr && value->is_number() ? value->number() : 0.0;
}
std::optional<double> read_maybe(const Node& node, std::string_view key) {
  const Node* const value = node.find(key);
  if (value == nullptr || !value->is_number()) return std::nullopt;
  return value->number();
}
std::string read_string(const Node& node, std::string_view key) {
  const Node* const value = node.find(key);
  return value != nullptr && value->is_text() ? value->text() : "";
}

Status status_of(std::string_view name) {
  for (const Status status : {Status::finished, Status::crashed, Status::timeout, Status::plugin_error})
    if (status_name(status) == name) return status;
  return Status::error;
}

RunTiming read_timing(const std::filesystem::path& folder) {
  RunTiming timing;
  const CsvTable table = read_csv(folder / "timing.csv");
  if (table.rows() == 0) return timing;
  const std::vector<double> solve = table.column("solve_ms");
  timing.solve_ms_median = nearest_rank_quantile(solve, 0.5);
  timing.solve_ms_p95 = nearest_rank_quantile(solve, 0.95);
  timing.solve_ms_p99 = nearest_rank_quantile(solve, 0.99);
  timing.update_ms_median = nearest_rank_quantile(table.column("update_ms"), 0.5);
  timing.cpu_s = table.column("cpu_s").back();
  return timing;
}

}  // namespace

void write_summary(const std::filesystem::path& folder, const RunSummary& s, const std::string& key) {
  Node node{Node::Object{}};
  node.set("stack", Node(s.stack));
  node.set("seed", Node(static_cast<double>(s.seed)));
  node.set("status", Node(status_name(s.status)));
  node.set("message", Node(s.message));
  node.set("needs_truth", Node(s.needs_truth));
  node.set("lap_s", numbers(s.laps));
  node.set("lap_mean_factor", numbers(s.lap_mean_factors));
  node.set("mean_deviation_m", Node(s.mean_deviation_m));
  node.set("hilly_deviation_m", number_or_null(s.hilly_deviation_m));
  node.set("violation_s", Node(s.violation_s));
  node.set("violation_body_s", Node(s.violation_body_s));
  node.set("violation_after_adapt_s", number_or_null(s.violation_after_adapt_s));
  node.set("mu_rmse", number_or_null(s.mu_rmse));
  node.set("mu_bias", number_or_null(s.mu_bias));
  node.set("mu_visited_rmse", number_or_null(s.mu_visited_rmse));
  node.set("solver_failures", Node(static_cast<double>(s.solver_failures)));
  node.set("steps", Node(static_cast<double>(s.steps)));
  node.set("simulated_s", Node(s.simulated_s));
  node.set("key", Node(key));
  write_file(folder / "summary.json", to_json_text(node));
}

std::optional<RunResult> read_result(const std::filesystem::path& folder, const std::string& key) {
  std::error_code ignored;
  if (!std::filesystem::exists(folder / "summary.json", ignored)) return std::nullopt;
  try {
    const Node node = parse_file(folder / "summary.json");
    if (!key.empty() && read_string(node, "key") != key) return std::nullopt;
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
    s.mean_deviation_m = read_value(node, "mean_deviation_m");
    s.hilly_deviation_m = read_maybe(node, "hilly_deviation_m");
    s.violation_s = read_value(node, "violation_s");
    s.violation_body_s = read_value(node, "violation_body_s");
    s.violation_after_adapt_s = read_maybe(node, "violation_after_adapt_s");
    s.mu_rmse = read_maybe(node, "mu_rmse");
    s.mu_bias = read_maybe(node, "mu_bias");
    s.mu_visited_rmse = read_maybe(node, "mu_visited_rmse");
    s.solver_failures = static_cast<std::int64_t>(read_value(node, "solver_failures"));
    s.steps = static_cast<std::int64_t>(read_value(node, "steps"));
    s.simulated_s = read_value(node, "simulated_s");
    if (std::filesystem::exists(folder / "timing.csv", ignored)) result.timing = read_timing(folder);
    return result;
  } catch (const std::exception&) {
    return std::nullopt;  // half-written by a run that died: as if absent
  }
}

}  // namespace gripline
