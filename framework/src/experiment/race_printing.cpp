#include "experiment/race_printing.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <ostream>

#include "experiment/race_judging.hpp"
#include "util/numbers.hpp"
#include "util/resampling.hpp"
#include "util/text_table.hpp"

namespace gripline {
namespace {

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
    if (const std::size_t n = results.values_of(runs, column).size();
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

/// " left the road in 2 of 16 runs, for 2.64 s in the worst (seed 5)" where a column of times outside shows 0.00 s for a
/// row and not for each of its runs; else empty.
std::string hidden_by_median(const RaceResults& results, const std::string& stack, const std::string& column) {
  const auto shown = [](const std::optional<double>& value) { return cell_text(value, "%.2f s"); };
  const std::string inside = shown(0.0);
  const std::vector<const RunResult*> runs = results.distinct(stack);
  // Of fewer runs the range is printed, whose upper end is the worst.
  if (runs.size() < least_for_interval || shown(results.value(stack, column, -1)) != inside) return {};
  std::size_t left = 0;
  double longest = 0.0;
  std::uint64_t seed = 0;
  for (const RunResult* run : runs) {
    const std::optional<double> outside = results.run_value(*run, column);
    if (!outside || shown(outside) == inside) continue;
    ++left;
    if (*outside > longest) longest = *outside, seed = run->summary.seed;
  }
  if (left == 0) return {};
  return " left the road in " + std::to_string(left) + " of " + std::to_string(runs.size()) + " runs, for " +
         shown(longest) + " in the worst (seed " + std::to_string(seed) + ")";
}

/// A line for every row whose medians say that it stayed on the road while some of its runs did not.
void print_hidden(std::ostream& out, const RaceResults& results) {
  for (const std::string& stack : results.rows) {
    const std::string centre = hidden_by_median(results, stack, "violation_s");
    const std::string corner = hidden_by_median(results, stack, "violation_body_s");
    if (centre.empty() && corner.empty()) continue;
    out << stack << ": ";
    if (!centre.empty()) out << "the centre of gravity" << centre << (corner.empty() ? "" : "; ");
    if (!corner.empty()) out << "a corner of the car" << corner;
    out << '\n';
  }
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
  const std::size_t laps = std::min<std::size_t>(results.most_laps(), 8);
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
  if (table.any_truth) out << "* is given the ground truth. ";
  out << "outside: time with the centre of gravity off the track; corner out: with a corner of the car; out, adapted: "
         "outside after the stack adapted.\n";
}

/// "4 against 2, 1 of 3 runs", or that it fails by single runs: the medians alone would then look true.
std::string why_it_fails(const ClaimResult& claim) {
  const std::string sides = cell_text(claim.left, "%.4g") + " against " + cell_text(claim.right, "%.4g");
  if (claim.runs == 0) return sides;
  const std::string held = std::to_string(claim.runs_held) + " of " + std::to_string(claim.runs) + " runs";
  if (!claim.medians_hold) return sides + ", " + held;
  return sides + " at the median, but holds in " + held + format(", %.4g %% wanted", 100.0 * claim.share);
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
      out << "  FAILS    " << claim.text << "   (" << why_it_fails(claim)
          << (claim.note.empty() ? "" : "; " + claim.note) << ")\n";
  }
  print_range_claims(out, claims);
  print_thin_claims(out, claims);
}

}  // namespace

void print_tables(std::ostream& out, const RaceResults& results, std::span<const ClaimResult> claims) {
  const PrintedTable table = table_rows(results);
  print_aligned(out, table.rows);
  print_hidden(out, results);
  print_identical(out, results);
  for (const std::string& line : beaten_limits(results)) out << "the stated limit is too slow: " << line << '\n';
  print_legend(out, table);
  print_claims(out, claims);
}

}  // namespace gripline
