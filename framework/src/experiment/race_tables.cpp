#include "experiment/race_tables.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ostream>

#include "config/node.hpp"
#include "util/csv_writer.hpp"
#include "util/statistics.hpp"

namespace gripline {
namespace {

std::size_t most_laps(const RaceResults& results) {
  std::size_t most = 0;
  for (const RunResult& run : results.runs) most = std::max(most, run.summary.laps.size());
  return most;
}

std::optional<double> pace_ratio(const RaceResults& results, const RunSummary& run, std::size_t lap) {
  if (lap >= run.laps.size()) return std::nullopt;
  const std::optional<double> best = results.race.world.time_optimal_lap(run.lap_mean_factors[lap]);
  if (!best) return std::nullopt;
  return run.laps[lap] / *best;
}

/// The number between `prefix` and `suffix`, or -1.
int numbered(const std::string& column, std::string_view prefix, std::string_view suffix) {
  if (!column.starts_with(prefix) || !column.ends_with(suffix)) return -1;
  const std::string digits = column.substr(prefix.size(), column.size() - prefix.size() - suffix.size());
  if (digits.empty() || !std::all_of(digits.begin(), digits.end(), [](unsigned char c) { return std::isdigit(c); }))
    return -1;
  return std::stoi(digits.substr(0, 6));
}

std::optional<double> at(const std::vector<double>& values, int index) {
  if (index < 0 || static_cast<std::size_t>(index) >= values.size()) return std::nullopt;
  return values[static_cast<std::size_t>(index)];
}

std::optional<double> run_value(const RaceResults& results, const RunResult& run, const std::string& column) {
  const RunSummary& s = run.summary;
  if (column == "runs") return 1.0;
  if (column == "finished") return s.status == Status::finished ? 1.0 : 0.0;
  if (column == "crashed") return s.status == Status::crashed ? 1.0 : 0.0;
  if (s.steps == 0) return std::nullopt;  // a run that was lost measured nothing
  if (column == "mean_deviation_m") return s.mean_deviation_m;
  if (column == "hilly_deviation_m") return s.hilly_deviation_m;
  if (column == "violation_s" || column == "violation_s_max") return s.violation_s;
  if (column == "violation_body_s") return s.violation_body_s;
  if (column == "violation_after_adapt_s" || column == "violation_after_adapt_s_max") return s.violation_after_adapt_s;
  if (column == "mu_rmse") return s.mu_rmse;
  if (column == "mu_visited_rmse") return s.mu_visited_rmse;
  if (column == "solve_ms_median") return run.timing.solve_ms_median;
  if (column == "solve_ms_p95") return run.timing.solve_ms_p95;
  if (column == "solve_ms_p99") return run.timing.solve_ms_p99;
  if (column == "update_ms_median") return run.timing.update_ms_median;
  if (column == "solver_failures") return static_cast<double>(s.solver_failures);
  if (column == "steps") return static_cast<double>(s.steps);
  if (column == "cpu_s") return run.timing.cpu_s;
  if (column == "simulated_s") return s.simulated_s;
  if (const int lap = numbered(column, "lap", "_mean_factor"); lap >= 0) return at(s.lap_mean_factors, lap);
  if (const int lap = numbered(column, "lap", "_s"); lap >= 0) return at(s.laps, lap);
  if (const int lap = numbered(column, "pace_ratio", ""); lap >= 0)
    return pace_ratio(results, s, static_cast<std::size_t>(lap));
  return std::nullopt;
}

std::vector<std::string> measured_columns(std::size_t laps) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < laps; ++i) names.push_back("lap" + std::to_string(i) + "_s");
  for (std::size_t i = 0; i < laps; ++i) names.push_back("lap" + std::to_string(i) + "_mean_factor");
  for (const char* name : {"mean_deviation_m", "violation_s", "violation_body_s", "violation_after_adapt_s", "mu_rmse",
                           "mu_visited_rmse", "solve_ms_median", "solve_ms_p95", "solve_ms_p99", "update_ms_median",
                           "solver_failures", "steps", "cpu_s", "simulated_s"})
    names.emplace_back(name);
  return names;
}

std::string joined(const std::vector<std::string>& names, std::string_view before) {
  std::string text(before);
  for (const std::string& name : names) text += "," + name;
  return text;
}

void put(CsvWriter& csv, const std::optional<double>& value) {
  if (!value)
    csv << NAN;
  else if (*value == std::floor(*value) && std::abs(*value) < 1e15)
    csv << static_cast<std::int64_t>(*value);
  else
    csv << *value;
}

void write_runs(const std::filesystem::path& out, const RaceResults& results, std::size_t laps) {
  const std::vector<std::string> columns = measured_columns(laps);
  std::string text;
  CsvWriter csv(text, joined(columns, "stack,seed,status,needs_truth"));
  for (const RunResult& run : results.runs) {
    csv << run.summary.stack << static_cast<std::int64_t>(run.summary.seed) << status_name(run.summary.status)
        << (run.summary.needs_truth ? 1 : 0);
    for (const std::string& column : columns) put(csv, run_value(results, run, column));
    csv.end_row();
  }
  write_file(out / "runs.csv", text);
}

void write_table(const std::filesystem::path& out, const RaceResults& results, std::size_t laps) {
  std::vector<std::string> columns = measured_columns(laps);
  for (const char* name : {"runs", "finished", "crashed", "violation_s_max", "violation_after_adapt_s_max"})
    columns.emplace_back(name);
  for (std::size_t i = 0; i < laps; ++i) columns.push_back("pace_ratio" + std::to_string(i));
  std::string text;
  CsvWriter csv(text, joined(columns, "stack,needs_truth"));
  for (const std::string& stack : results.rows) {
    const std::vector<const RunResult*> runs = results.of(stack);
    csv << stack << (!runs.empty() && runs.front()->summary.needs_truth ? 1 : 0);
    for (const std::string& column : columns) put(csv, results.value(stack, column, -1));
    csv.end_row();
  }
  write_file(out / "table.csv", text);
}

Node optional_number(const std::optional<double>& value) { return value ? Node(*value) : Node::null(); }

std::string text(const std::optional<double>& value, const char* format) {
  if (!value || std::isnan(*value)) return "-";
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, format, *value);
  // snprintf follows the locale's decimal sign; tables do not.
  for (char* c = buffer; *c != '\0'; ++c)
    if (*c == ',') *c = '.';
  return buffer;
}

/// Columns right-aligned, the first one left.
void print_aligned(std::ostream& out, const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> width;
  for (const auto& row : rows) {
    width.resize(std::max(width.size(), row.size()), 0);
    for (std::size_t i = 0; i < row.size(); ++i) width[i] = std::max(width[i], row[i].size());
  }
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string pad(width[i] - row[i].size(), ' ');
      line += i == 0 ? row[i] + pad : "  " + pad + row[i];
    }
    out << line << '\n';
  }
}

/// ", 85 % of solves failed" when that says more of the run than its status.
std::string failed_share(const std::vector<const RunResult*>& runs) {
  std::int64_t failures = 0, steps = 0;
  for (const RunResult* run : runs) {
    if (!run->summary.many_failed_solves()) continue;
    failures += run->summary.solver_failures;
    steps += run->summary.steps;
  }
  if (failures == 0) return {};
  return ", " + std::to_string(100 * failures / std::max<std::int64_t>(steps, 1)) + " % of solves failed";
}

std::string outcome(const std::vector<const RunResult*>& runs) {
  if (runs.size() == 1) return std::string(status_name(runs.front()->summary.status)) + failed_share(runs);
  const auto finished = std::count_if(runs.begin(), runs.end(),
                                      [](const RunResult* run) { return run->summary.status == Status::finished; });
  return std::to_string(finished) + "/" + std::to_string(runs.size()) + " finished" + failed_share(runs);
}

}  // namespace

std::vector<const RunResult*> RaceResults::of(const std::string& stack) const {
  std::vector<const RunResult*> found;
  for (const RunResult& run : runs)
    if (run.summary.stack == stack) found.push_back(&run);
  return found;
}

std::optional<double> RaceResults::value(const std::string& stack, const std::string& column, int run) const {
  const std::vector<const RunResult*> mine = of(stack);
  if (run >= 0)
    return static_cast<std::size_t>(run) < mine.size() ? run_value(*this, *mine[static_cast<std::size_t>(run)], column)
                                                       : std::nullopt;
  std::vector<double> values;
  for (const RunResult* one : mine)
    if (const std::optional<double> value = run_value(*this, *one, column); value && !std::isnan(*value))
      values.push_back(*value);
  const bool summed =
      column == "runs" || column == "finished" || column == "crashed" || column == "cpu_s" || column == "simulated_s";
  if (summed) {
    double sum = 0.0;
    for (const double value : values) sum += value;
    return sum;
  }
  if (column.ends_with("_max") && !values.empty()) return *std::max_element(values.begin(), values.end());
  if (values.empty()) return std::nullopt;
  return median(std::move(values));
}

std::vector<ClaimResult> judge_all(const RaceResults& results, bool alone) {
  std::vector<ClaimResult> judged;
  const auto present = [&](const ClaimTerm& term) {
    return term.stack.empty() || std::find(results.rows.begin(), results.rows.end(), term.stack) != results.rows.end();
  };
  for (const Claim& claim : results.race.claims) {
    ClaimResult skipped;
    skipped.text = claim.text;
    if (!present(claim.left) || !present(claim.right)) {
      skipped.why_skipped = "a row was left out by --only";
      judged.push_back(skipped);
    } else if (claim.about_time() && !alone) {
      skipped.why_skipped = "on times: needs -j 1";
      judged.push_back(skipped);
    } else {
      judged.push_back(judge(claim, static_cast<int>(results.race.seeds.size()), results.race.claim_share,
                             [&](const std::string& stack, const std::string& column, int run) {
                               return results.value(stack, column, run);
                             }));
    }
  }
  return judged;
}

void write_claims(const std::filesystem::path& out, std::span<const ClaimResult> claims) {
  Node::Array all;
  Node::Array skipped;
  for (const ClaimResult& claim : claims) {
    Node one{Node::Object{}};
    one.set("text", Node(claim.text));
    if (!claim.holds) {
      one.set("why", Node(claim.why_skipped));
      skipped.push_back(std::move(one));
      continue;
    }
    one.set("holds", Node(*claim.holds));
    Node values{Node::Object{}};
    values.set("left", optional_number(claim.left));
    values.set("right", optional_number(claim.right));
    values.set("runs_held", Node(static_cast<double>(claim.runs_held)));
    values.set("runs", Node(static_cast<double>(claim.runs)));
    one.set("values", std::move(values));
    all.push_back(std::move(one));
  }
  Node root{Node::Object{}};
  root.set("claims", Node(std::move(all)));
  root.set("skipped", Node(std::move(skipped)));
  write_file(out / "claims.json", to_json_text(root));
}

void write_tables(const std::filesystem::path& out, const RaceResults& results, std::span<const ClaimResult> claims) {
  const std::size_t laps = std::max(most_laps(results), static_cast<std::size_t>(results.race.world.laps));
  write_runs(out, results, laps);
  write_table(out, results, laps);
  write_claims(out, claims);
}

void print_tables(std::ostream& out, const RaceResults& results, std::span<const ClaimResult> claims) {
  const std::size_t laps = std::min<std::size_t>(most_laps(results), 8);
  std::vector<std::vector<std::string>> rows(1);
  rows[0] = {"stack"};
  for (std::size_t i = 0; i < laps; ++i) rows[0].push_back("lap " + std::to_string(i));
  for (const char* name : {"deviation", "outside", "adapted", "mu rms", "solve", "failed", "CPU", "status"})
    rows[0].emplace_back(name);
  bool any_truth = false;
  for (const std::string& stack : results.rows) {
    const std::vector<const RunResult*> runs = results.of(stack);
    if (runs.empty()) continue;
    const bool truth = runs.front()->summary.needs_truth;
    any_truth = any_truth || truth;
    const auto cell = [&](const char* column, const char* format) {
      return text(results.value(stack, column, -1), format);
    };
    std::vector<std::string> row = {stack + (truth ? " *" : "")};
    for (std::size_t i = 0; i < laps; ++i) row.push_back(cell(("lap" + std::to_string(i) + "_s").c_str(), "%.2f"));
    row.push_back(cell("mean_deviation_m", "%.4f m"));
    row.push_back(cell("violation_s", "%.2f s"));
    row.push_back(cell("violation_after_adapt_s", "%.2f s"));
    row.push_back(cell("mu_rmse", "%.3f"));
    row.push_back(cell("solve_ms_median", "%.2f ms"));
    row.push_back(cell("solver_failures", "%.0f"));
    row.push_back(cell("cpu_s", "%.1f s"));
    row.push_back(outcome(runs));
    rows.push_back(std::move(row));
  }
  print_aligned(out, rows);
  if (any_truth) out << "* was told the truth. ";
  out << "outside: time with the centre of gravity off the track; adapted: the same after the stack adapted.\n";
  const auto held =
      std::count_if(claims.begin(), claims.end(), [](const ClaimResult& c) { return c.holds.value_or(false); });
  const auto judged =
      std::count_if(claims.begin(), claims.end(), [](const ClaimResult& c) { return c.holds.has_value(); });
  if (claims.empty()) return;
  out << "claims: " << held << " of " << judged << " hold";
  if (static_cast<std::size_t>(judged) < claims.size())
    out << ", " << claims.size() - static_cast<std::size_t>(judged) << " skipped";
  out << '\n';
  for (const ClaimResult& claim : claims) {
    if (!claim.holds)
      out << "  skipped  " << claim.text << "   (" << claim.why_skipped << ")\n";
    else if (!*claim.holds)
      out << "  FAILS    " << claim.text << "   (" << text(claim.left, "%.4g") << " against "
          << text(claim.right, "%.4g") << ", " << claim.runs_held << " of " << claim.runs << " runs)\n";
  }
}

}  // namespace gripline
