#include "experiment/race_tables.hpp"

#include <algorithm>
#include <cmath>

#include "config/node.hpp"
#include "experiment/race_columns.hpp"
#include "experiment/result_files.hpp"
#include "util/csv_writer.hpp"

namespace gripline {
namespace {

std::string joined(const std::vector<std::string>& names, std::string_view before) {
  std::string text(before);
  for (const std::string& name : names) text += "," + name;
  return text;
}

void write_cell(CsvWriter& csv, const std::optional<double>& value) {
  if (!value)
    csv << NAN;
  else if (*value == std::floor(*value) && std::abs(*value) < 1e15)
    csv << static_cast<std::int64_t>(*value);
  else
    csv << *value;
}

void write_runs(const std::filesystem::path& out, const RaceResults& results, std::size_t laps) {
  const std::vector<std::string> columns = race_column_names("runs.csv", laps);
  std::string text;
  CsvWriter csv(text, joined(columns, "stack,seed,status,needs_truth"));
  for (const RunResult& run : results.runs) {
    csv << run.summary.stack << static_cast<std::int64_t>(run.summary.seed) << status_name(run.summary.status)
        << (run.summary.needs_truth ? 1 : 0);
    for (const std::string& column : columns) write_cell(csv, results.run_value(run, column));
    csv.end_row();
  }
  write_file(out / result_files::runs, text);
}

void write_table(const std::filesystem::path& out, const RaceResults& results, std::size_t laps) {
  std::vector<std::string> columns = race_column_names("table.csv", laps);
  for (const std::string& column : interval_columns(results))
    for (const char* end : {"_lo", "_hi"}) columns.push_back(column + end);
  std::string text;
  CsvWriter csv(text, joined(columns, "stack,needs_truth"));
  for (const std::string& stack : results.rows) {
    const std::vector<const RunResult*> runs = results.of(stack);
    csv << stack << (!runs.empty() && runs.front()->summary.needs_truth ? 1 : 0);
    for (const std::string& column : columns) write_cell(csv, results.value(stack, column, -1));
    csv.end_row();
  }
  write_file(out / result_files::table, text);
}

}  // namespace

void write_claims(const std::filesystem::path& out, std::span<const ClaimResult> claims) {
  Node::Array all;
  Node::Array skipped;
  for (const ClaimResult& claim : claims) {
    Node one = Node::empty_object();
    one.set("text", Node(claim.text));
    if (!claim.holds) {
      one.set("why", Node(claim.why_skipped));
      skipped.push_back(std::move(one));
      continue;
    }
    one.set("holds", Node(*claim.holds));
    Node values = Node::empty_object();
    values.set("left", number_or_null(claim.left));
    values.set("right", number_or_null(claim.right));
    values.set("medians_hold", Node(claim.medians_hold));
    values.set("runs_held", Node(static_cast<double>(claim.runs_held)));
    values.set("runs", Node(static_cast<double>(claim.runs)));
    values.set("share", Node(claim.share));
    one.set("values", std::move(values));
    if (!claim.note.empty()) one.set("why", Node(claim.note));
    all.push_back(std::move(one));
  }
  Node root = Node::empty_object();
  root.set("claims", Node(std::move(all)));
  root.set("skipped", Node(std::move(skipped)));
  write_file(out / result_files::claims, to_json_text(root));
}

void write_tables(const std::filesystem::path& out, const RaceResults& results, std::span<const ClaimResult> claims) {
  const std::size_t laps = std::max(results.most_laps(), static_cast<std::size_t>(results.race.world.laps));
  write_runs(out, results, laps);
  write_table(out, results, laps);
  write_claims(out, claims);
}

}  // namespace gripline
