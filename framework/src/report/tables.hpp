// The tables, claims and step times of a report as JSON for its page.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "report/inputs.hpp"
#include "report/series.hpp"

namespace gripline::report {

/// {"columns": [name...], "rows": [{"stack", "values", "low", "high", "n"}]}: the numeric columns of table.csv (without
/// one, medians of runs.csv), with intervals of the median over the runs: those of table.csv (COLUMN_lo, COLUMN_hi),
/// else drawn as they are (bootstrap_median_interval) where runs.csv has the same column.
nlohmann::json table_json(const Inputs& inputs);

/// [{"stack", "baseline", "column", "difference", "lo", "hi", "p", "draws"}] of pairs.csv, stacks as indices into
/// inputs.stacks; rows without a draw are left out.
nlohmann::json pairs_json(const Inputs& inputs);

/// [{"stack", "seed", "status", "message", "values": {column: number}}], stack as an index into inputs.stacks; the
/// message is that of the run's summary.json.
nlohmann::json runs_json(const Inputs& inputs);

/// [{"text", "holds": true | false | null, "values", "why"}], those that were skipped at the end. `values` as written:
/// {"left", "right", "medians_hold", "runs_held", "runs", "share"}.
nlohmann::json claims_json(const nlohmann::json& claims);

/// Step times of one stack, pooled over its runs, in bins of equal width on a logarithmic axis.
class TimeHistogram {
 public:
  static constexpr int bins_per_decade = 20;
  static constexpr double first_ms = 1e-4;
  static constexpr int bin_count = 9 * bins_per_decade;

  void add(double milliseconds);
  /// {"n", "median", "p95", "p99", "max", "bins": [[index, count]...]}; shares by nearest rank (metrics.md)
  [[nodiscard]] nlohmann::json json() const;

 private:
  std::map<int, std::int64_t> bins_;
  std::vector<float> values_;
};

CarShape car_shape(const nlohmann::json& scene);

/// Index into inputs.stacks of a row of table.csv: a table that somebody edited may name a stack twice.
std::size_t stack_of_row(const Inputs& inputs, std::size_t row);

}  // namespace gripline::report
