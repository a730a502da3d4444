#include "experiment/pairs.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <ostream>
#include <set>

#include "experiment/result_files.hpp"
#include "util/csv_writer.hpp"
#include "util/resampling.hpp"
#include "util/statistics.hpp"
#include "util/text_table.hpp"

namespace gripline {
namespace {

/// Runs of the baseline by seed.
std::map<std::uint64_t, const RunResult*> by_seed(const std::vector<const RunResult*>& runs) {
  std::map<std::uint64_t, const RunResult*> found;
  for (const RunResult* run : runs) found[run->summary.seed] = run;
  return found;
}

struct Pair {
  const RunResult *stack, *baseline;
};

/// Both rows' runs of the same seed; pairs that are equal to the last bit in both rows only once.
std::vector<Pair> pairs_of(const RaceResults& results, const std::string& stack, const std::string& baseline) {
  const auto others = by_seed(results.of(baseline));
  std::set<std::pair<std::string, std::string>> seen;
  std::vector<Pair> pairs;
  for (const RunResult* run : results.of(stack)) {
    const auto other = others.find(run->summary.seed);
    if (other == others.end()) continue;
    const bool known = !run->drive.empty() && !other->second->drive.empty();
    if (known && !seen.emplace(run->drive, other->second->drive).second) continue;
    pairs.push_back({run, other->second});
  }
  return pairs;
}

PairedDifference difference_of(const RaceResults& results, const std::vector<Pair>& pairs, const std::string& stack,
                               const std::string& column) {
  std::vector<double> differences;
  for (const Pair& pair : pairs) {
    const std::optional<double> a = results.run_value(*pair.stack, column),
                                b = results.run_value(*pair.baseline, column);
    if (a && b && std::isfinite(*a) && std::isfinite(*b)) differences.push_back(*a - *b);
  }
  PairedDifference row;
  row.stack = stack;
  row.column = column;
  row.draws = static_cast<int>(differences.size());
  if (differences.empty()) return row;
  row.p = sign_test(differences);
  row.difference = median(differences);
  if (const MedianInterval i = bootstrap_median_interval(std::move(differences)); !std::isnan(i.lo)) {
    row.lo = i.lo;
    row.hi = i.hi;
  }
  return row;
}

}  // namespace

std::vector<PairedDifference> paired_differences(const RaceResults& results, const std::string& baseline) {
  std::vector<PairedDifference> all;
  for (const std::string& stack : results.rows) {
    if (stack == baseline) continue;
    const std::vector<Pair> pairs = pairs_of(results, stack, baseline);
    for (const std::string& column : interval_columns(results))
      all.push_back(difference_of(results, pairs, stack, column));
  }
  return all;
}

void write_pairs(const std::filesystem::path& out, const std::string& baseline,
                 std::span<const PairedDifference> pairs) {
  std::string text;
  CsvWriter csv(text, "stack,baseline,column,difference,lo,hi,p,draws");
  for (const PairedDifference& pair : pairs) {
    csv << pair.stack << baseline << pair.column;
    for (const std::optional<double>& value : {pair.difference, pair.lo, pair.hi}) csv << value.value_or(NAN);
    csv << (pair.draws > 0 ? pair.p : NAN) << pair.draws;
    csv.end_row();
  }
  write_file(out / result_files::pairs, text);
}

void print_pairs(std::ostream& out, const std::string& baseline, std::span<const PairedDifference> pairs) {
  const auto shown = [](const std::string& column) {
    return (column.starts_with("lap") && column.ends_with("_s")) || column == "mean_deviation_m" ||
           column == "violation_s" || column == "violation_body_s" || column == "mu_rmse";
  };
  constexpr auto enough = static_cast<int>(least_for_interval);
  bool any_range = false, any_interval = false;
  std::vector<std::vector<std::string>> rows = {{"minus " + baseline, "column", "median", "", "p", "least p", "draws"}};
  for (const PairedDifference& pair : pairs) {
    if (!shown(pair.column) || pair.draws == 0) continue;
    (pair.draws < enough ? any_range : any_interval) = true;
    const std::string interval = pair.lo ? cell_text(pair.lo, "%+.3f") + " to " + cell_text(pair.hi, "%+.3f") : "-";
    rows.push_back({pair.stack, pair.column, cell_text(pair.difference, "%+.3f"), interval, cell_text(pair.p, "%.2g"),
                    cell_text(least_sign_test(static_cast<std::size_t>(pair.draws)), "%.2g"),
                    std::to_string(pair.draws)});
  }
  rows.front()[3] = !any_range ? "95 %" : any_interval ? "95 % or range" : "range";
  print_aligned(out, rows);
  out << "median: of the differences draw by draw";
  if (any_interval) out << "; 95 %: its bootstrap interval";
  if (any_range) out << "; range, of fewer than " << enough << " draws: the smallest and largest difference";
  out << "; p: sign test; least p: if all draws had one sign. All columns: pairs.csv\n";
}

}  // namespace gripline
