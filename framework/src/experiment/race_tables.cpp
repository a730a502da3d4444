#include "experiment/race_tables.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <ostream>
#include <set>

#include "config/node.hpp"
#include "experiment/race_columns.hpp"
#include "util/csv_writer.hpp"
#include "util/numbers.hpp"
#include "util/resampling.hpp"
#include "util/statistics.hpp"

namespace gripline {
namespace {

std::size_t most_laps(const RaceResults& results) {
  std::size_t most = 0;
  for (const RunResult& run : results.runs) most = std::max(most, run.summary.laps.size());
  return most;
}

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
  write_file(out / "runs.csv", text);
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
  write_file(out / "table.csv", text);
}

Node optional_number(const std::optional<double>& value) { return value ? Node(*value) : Node::null(); }

/// ", 85 % of solves failed" when that says more of the run than its status.
std::string failed_share(const std::vector<const RunResult*>& runs) {
  std::int64_t failures = 0, solves = 0;
  for (const RunResult* run : runs) {
    if (!run->summary.many_failed_solves()) continue;
    failures += run->summary.solver_failures;
    solves += run->summary.solves();
  }
  if (failures == 0) return {};
  return ", " + std::to_string(100 * failures / solves) + " % of solves failed";
}

std::string outcome(const std::vector<const RunResult*>& runs) {
  if (runs.size() == 1) return std::string(status_name(runs.front()->summary.status)) + failed_share(runs);
  const auto finished = std::count_if(runs.begin(), runs.end(),
                                      [](const RunResult* run) { return run->summary.status == Status::finished; });
  return std::to_string(finished) + "/" + std::to_string(runs.size()) + " finished" + failed_share(runs);
}

std::vector<double> values_of(const RaceResults& results, const std::vector<const RunResult*>& runs,
                              const std::string& column) {
  std::vector<double> values;
  for (const RunResult* one : runs)
    if (const std::optional<double> value = results.run_value(*one, column); value && !std::isnan(*value))
      values.push_back(*value);
  return values;
}

/// The ends of the intervals under a row of the printed table, or of the ranges where the runs are too few for one;
/// empty when no column has one.
std::vector<std::string> interval_row(const RaceResults& results, const std::string& stack, std::size_t laps) {
  const std::vector<const RunResult*> runs = results.distinct(stack);
  std::vector<std::string> row = {runs.size() < least_for_interval ? "  range" : "  95 %"};
  bool any = false;
  const auto add = [&](const std::string& column, const char* format) {
    const std::optional<double> lo = results.value(stack, column + "_lo", -1);
    const std::optional<double> hi = results.value(stack, column + "_hi", -1);
    any = any || (lo && hi);
    row.push_back(lo && hi ? cell_text(lo, format) + ".." + cell_text(hi, format) : "");
    // A lap that few of many runs drove.
    if (const std::size_t n = values_of(results, runs, column).size();
        lo && hi && n < least_for_interval && n < runs.size() && runs.size() >= least_for_interval)
      row.back() += " of " + std::to_string(n);
  };
  for (std::size_t i = 0; i < laps; ++i) add("lap" + std::to_string(i) + "_s", "%.2f");
  add("mean_deviation_m", "%.4f");
  for (const char* column : {"violation_s", "violation_body_s", "violation_after_adapt_s"}) add(column, "%.2f");
  add("mu_rmse", "%.3f");
  if (!any) row.clear();
  return row;
}

/// "1, 2, 3", the first few of them.
std::string some_seeds(const std::vector<std::uint64_t>& seeds) {
  constexpr std::size_t most = 6;
  std::string text;
  for (std::size_t i = 0; i < std::min(seeds.size(), most); ++i) text += (i > 0 ? ", " : "") + std::to_string(seeds[i]);
  if (seeds.size() > most) text += " and " + std::to_string(seeds.size() - most) + " more";
  return text;
}

/// "none: seeds 1, 2 drove the same run to the last bit, which counts once; 3, 4, 5 would too and were not driven"
void print_identical(std::ostream& out, const RaceResults& results) {
  for (const std::string& stack : results.rows) {
    std::map<std::string, std::pair<std::vector<std::uint64_t>, std::vector<std::uint64_t>>> seeds;
    for (const RunResult* run : results.of(stack)) {
      auto& [driven, spared] = seeds[run->drive];
      if (!run->drive.empty()) (run->driven_as ? spared : driven).push_back(run->summary.seed);
    }
    for (const auto& [drive, same] : seeds) {
      if (same.first.size() + same.second.size() < 2) continue;
      out << stack << ": seeds " << some_seeds(same.first) << " drove the same run to the last bit, which counts once";
      if (!same.second.empty()) out << "; " << some_seeds(same.second) << " would too and were not driven";
      out << '\n';
    }
  }
}

/// "" or what the ends that a claim names are when the runs of a row are too few for an interval.
std::string range_note(const RaceResults& results, const Claim& claim) {
  std::string note;
  for (const ClaimTerm* term : {&claim.left, &claim.right}) {
    const std::string of(interval_of(term->column));
    if (of.empty()) continue;
    const std::size_t runs = values_of(results, results.distinct(term->stack), of).size();
    if (runs >= least_for_interval || runs < 2 || !note.empty()) continue;
    note = "_lo and _hi are the smallest and largest of " + std::to_string(runs) + " runs, no 95 % interval";
  }
  return note;
}

/// Warns of claims whose ends of intervals are ranges; of those that fail, their line says so.
void print_range_claims(std::ostream& out, std::span<const ClaimResult> claims) {
  for (const ClaimResult& claim : claims)
    if (claim.holds.value_or(false) && !claim.note.empty())
      out << "warning: " << claim.text << ": " << claim.note << '\n';
}

/// Warns of claims that were judged on a single run.
void print_thin_claims(std::ostream& out, std::span<const ClaimResult> claims) {
  const auto thin = std::count_if(claims.begin(), claims.end(),
                                  [](const ClaimResult& c) { return c.holds.has_value() && c.runs == 1; });
  if (thin == 0) return;
  out << "warning: " << (thin == 1 ? "a claim rests" : std::to_string(thin) + " claims rest")
      << " on one run; more seeds, sensor noise or \"perturb\" say how far " << (thin == 1 ? "it holds" : "they hold")
      << '\n';
}

}  // namespace

std::string cell_text(const std::optional<double>& value, const char* pattern) {
  return !value || std::isnan(*value) ? "-" : format(pattern, *value);
}

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

std::vector<std::string> interval_columns(const RaceResults& results) {
  const std::size_t laps = std::max(most_laps(results), static_cast<std::size_t>(results.race.world.laps));
  std::vector<std::string> columns = race_column_names("table.csv", laps);
  std::erase_if(columns, [](const std::string& column) { return !is_table_column(column + "_lo"); });
  return columns;
}

namespace {

/// Whether a lap begins with speed from better friction: then it may be faster than a flying lap at its own.
bool enters_faster(const RunSummary& run, std::size_t lap) {
  constexpr double drop = 0.05;  // of the friction factor: a fading that slow hardly matters
  return run.lap_mean_factors[lap - 1] > run.lap_mean_factors[lap] + drop;
}

/// `inside` says what of the car never left the road.
void add_beaten(const RunSummary& run, const LapTable& limits, const char* inside, std::vector<std::string>& beaten) {
  for (std::size_t lap = 1; lap < run.laps.size(); ++lap) {
    const std::optional<double> limit = limits.at(run.lap_mean_factors[lap]);
    if (!limit || run.laps[lap] >= *limit - limits.error || enters_faster(run, lap)) continue;
    beaten.push_back(run.stack + ", seed " + std::to_string(run.seed) + ": lap " + std::to_string(lap) + " took " +
                     cell_text(run.laps[lap], "%.3f") + " s " + inside + " the road, the limit is " +
                     cell_text(*limit, "%.3f") + " s with an error of " + cell_text(limits.error, "%.3f") + " s");
  }
}

}  // namespace

std::vector<std::string> beaten_limits(const RaceResults& results) {
  std::vector<std::string> beaten;
  const WorldSpec& world = results.race.world;
  for (const RunResult& run : results.runs) {
    if (run.summary.steps == 0) continue;
    if (run.summary.violation_s <= 0.0) add_beaten(run.summary, world.time_optimal, "inside", beaten);
    if (run.summary.violation_body_s <= 0.0)
      add_beaten(run.summary, world.time_optimal_body, "with the whole car inside", beaten);
  }
  return beaten;
}

std::vector<const RunResult*> RaceResults::distinct(const std::string& stack) const {
  std::vector<const RunResult*> found;
  std::set<std::string> drives;
  for (const RunResult* run : of(stack))
    if (run->drive.empty() || drives.insert(run->drive).second) found.push_back(run);
  return found;
}

std::optional<double> RaceResults::run_value(const RunResult& run, const std::string& column) const {
  const std::optional<NamedColumn> named = find_race_column(column);
  return named ? named->column->read(race.world, run, named->lap) : std::nullopt;
}

std::vector<const RunResult*> RaceResults::of(const std::string& stack) const {
  std::vector<const RunResult*> found;
  for (const RunResult& run : runs)
    if (run.summary.stack == stack) found.push_back(&run);
  return found;
}

std::optional<double> RaceResults::value(const std::string& stack, const std::string& column, int run) const {
  if (run >= 0) {
    const std::vector<const RunResult*> mine = of(stack);
    return static_cast<std::size_t>(run) < mine.size() ? run_value(*mine[static_cast<std::size_t>(run)], column)
                                                       : std::nullopt;
  }
  if (const std::string of(interval_of(column)); !of.empty()) {
    const MedianInterval interval = bootstrap_median_interval(values_of(*this, distinct(stack), of));
    const double end = column.ends_with("_lo") ? interval.lo : interval.hi;
    return std::isnan(end) ? std::nullopt : std::optional(end);
  }
  const std::optional<NamedColumn> named = find_race_column(column);
  if (!named) return std::nullopt;
  const RowSum sum = named->column->sum;
  std::vector<double> values = values_of(*this, sum == RowSum::cost ? of(stack) : distinct(stack), column);
  if (values.empty() && (column == "solver_failures" || sum == RowSum::median || sum == RowSum::largest))
    return std::nullopt;
  if (sum == RowSum::median) return gripline::median(std::move(values));
  if (sum == RowSum::largest) return *std::max_element(values.begin(), values.end());
  return std::accumulate(values.begin(), values.end(), 0.0);
}

/// The runs that a claim is asked of one by one: those that are equal to the last bit in both its rows only once.
static std::vector<int> distinct_runs(const RaceResults& results, const Claim& claim) {
  std::vector<int> chosen;
  std::set<std::pair<std::string, std::string>> seen;
  const std::vector<const RunResult*> left = results.of(claim.left.stack), right = results.of(claim.right.stack);
  const auto drive = [](const std::vector<const RunResult*>& runs, std::size_t i) {
    return i < runs.size() ? runs[i]->drive : std::string();
  };
  for (std::size_t i = 0; i < results.race.seeds.size(); ++i) {
    const auto both = std::pair(drive(left, i), drive(right, i));
    const bool known =
        (claim.left.stack.empty() || !both.first.empty()) && (claim.right.stack.empty() || !both.second.empty());
    if (!known || seen.insert(both).second) chosen.push_back(static_cast<int>(i));
  }
  return chosen;
}

/// Whether all runs of the rows that a claim names were driven alone. A run that was lost has no times.
static bool driven_alone(const RaceResults& results, const Claim& claim) {
  return std::ranges::all_of(results.runs, [&](const RunResult& run) {
    const bool named = run.summary.stack == claim.left.stack || run.summary.stack == claim.right.stack;
    return !named || run.summary.steps == 0 || run.timing.alone;
  });
}

std::vector<ClaimResult> judge_all(const RaceResults& results) {
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
    } else if (claim.about_time() && !driven_alone(results, claim)) {
      skipped.why_skipped = times_not_alone;
      judged.push_back(skipped);
    } else {
      const std::vector<int> chosen = distinct_runs(results, claim);
      judged.push_back(judge(claim, static_cast<int>(chosen.size()), results.race.claim_share,
                             [&](const std::string& stack, const std::string& column, int run) {
                               return results.value(stack, column,
                                                    run < 0 ? -1 : chosen[static_cast<std::size_t>(run)]);
                             }));
      judged.back().note = range_note(results, claim);
    }
  }
  return judged;
}

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
    values.set("left", optional_number(claim.left));
    values.set("right", optional_number(claim.right));
    values.set("runs_held", Node(static_cast<double>(claim.runs_held)));
    values.set("runs", Node(static_cast<double>(claim.runs)));
    one.set("values", std::move(values));
    if (!claim.note.empty()) one.set("why", Node(claim.note));
    all.push_back(std::move(one));
  }
  Node root = Node::empty_object();
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

namespace {

/// The table as people read it, and what its legend has to explain.
struct PrintedTable {
  std::vector<std::vector<std::string>> rows;
  bool any_truth = false, any_interval = false, any_range = false;
};

std::vector<std::string> head_row(std::size_t laps) {
  std::vector<std::string> row = {"stack"};
  for (std::size_t i = 0; i < laps; ++i) row.push_back("lap " + std::to_string(i));
  for (const char* name :
       {"deviation", "outside", "corner out", "out, adapted", "mu rms", "solve", "failed", "CPU", "status"})
    row.emplace_back(name);
  return row;
}

std::vector<std::string> stack_row(const RaceResults& results, const std::string& stack,
                                   const std::vector<const RunResult*>& runs, std::size_t laps) {
  const auto cell = [&](const char* column, const char* pattern) {
    return cell_text(results.value(stack, column, -1), pattern);
  };
  std::vector<std::string> row = {stack + (runs.front()->summary.needs_truth ? " *" : "")};
  for (std::size_t i = 0; i < laps; ++i) row.push_back(cell(("lap" + std::to_string(i) + "_s").c_str(), "%.2f"));
  row.push_back(cell("mean_deviation_m", "%.4f m"));
  row.push_back(cell("violation_s", "%.2f s"));
  row.push_back(cell("violation_body_s", "%.2f s"));
  row.push_back(cell("violation_after_adapt_s", "%.2f s"));
  row.push_back(cell("mu_rmse", "%.3f"));
  row.push_back(cell("solve_ms_median", "%.2f ms"));
  row.push_back(cell("solver_failures", "%.0f"));
  row.push_back(cell("cpu_s", "%.1f s"));
  row.push_back(outcome(runs));
  return row;
}

PrintedTable table_rows(const RaceResults& results) {
  const std::size_t laps = std::min<std::size_t>(most_laps(results), 8);
  PrintedTable table{.rows = {head_row(laps)}};
  for (const std::string& stack : results.rows) {
    const std::vector<const RunResult*> runs = results.distinct(stack);
    if (runs.empty()) continue;
    table.any_truth = table.any_truth || runs.front()->summary.needs_truth;
    table.rows.push_back(stack_row(results, stack, runs, laps));
    std::vector<std::string> ends = interval_row(results, stack, laps);
    if (ends.empty()) continue;
    (runs.size() < least_for_interval ? table.any_range : table.any_interval) = true;
    table.any_range =
        table.any_range || std::ranges::any_of(ends, [](const auto& cell) { return cell.find(" of ") != cell.npos; });
    table.rows.push_back(std::move(ends));
  }
  return table;
}

void print_legend(std::ostream& out, const PrintedTable& table) {
  if (table.any_interval) out << "95 %: bootstrap interval of the median over the runs. ";
  if (table.any_range)
    out << (table.any_interval ? "range, or \"of\" fewer than " : "range, of fewer than ") << least_for_interval
        << " runs: smallest and largest. ";
  if (table.any_truth) out << "* was told the truth. ";
  out << "outside: time with the centre of gravity off the track; corner out: with a corner of the car; out, adapted: "
         "outside after the stack adapted.\n";
}

/// How many claims hold, and those that do not.
void print_claims(std::ostream& out, std::span<const ClaimResult> claims) {
  if (claims.empty()) return;
  const auto held =
      std::count_if(claims.begin(), claims.end(), [](const ClaimResult& c) { return c.holds.value_or(false); });
  const auto judged =
      std::count_if(claims.begin(), claims.end(), [](const ClaimResult& c) { return c.holds.has_value(); });
  out << "claims: " << held << " of " << judged << " hold";
  if (static_cast<std::size_t>(judged) < claims.size())
    out << ", " << claims.size() - static_cast<std::size_t>(judged) << " skipped";
  out << '\n';
  for (const ClaimResult& claim : claims) {
    if (!claim.holds)
      out << "  skipped  " << claim.text << "   (" << claim.why_skipped << ")\n";
    else if (!*claim.holds)
      out << "  FAILS    " << claim.text << "   (" << cell_text(claim.left, "%.4g") << " against "
          << cell_text(claim.right, "%.4g")
          << (claim.runs > 0 ? ", " + std::to_string(claim.runs_held) + " of " + std::to_string(claim.runs) + " runs"
                             : std::string())
          << (claim.note.empty() ? "" : "; " + claim.note) << ")\n";
  }
  print_range_claims(out, claims);
  print_thin_claims(out, claims);
}

}  // namespace

void print_tables(std::ostream& out, const RaceResults& results, std::span<const ClaimResult> claims) {
  const PrintedTable table = table_rows(results);
  print_aligned(out, table.rows);
  print_identical(out, results);
  for (const std::string& line : beaten_limits(results)) out << "the stated limit is too slow: " << line << '\n';
  print_legend(out, table);
  print_claims(out, claims);
}

}  // namespace gripline
