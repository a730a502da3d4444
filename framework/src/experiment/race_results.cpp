#include "experiment/race_results.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "experiment/race_columns.hpp"
#include "util/resampling.hpp"
#include "util/statistics.hpp"

namespace gripline {

std::vector<const RunResult*> RaceResults::of(const std::string& stack) const {
  std::vector<const RunResult*> found;
  for (const RunResult& run : runs)
    if (run.summary.stack == stack) found.push_back(&run);
  return found;
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

std::vector<double> RaceResults::values_of(const std::vector<const RunResult*>& of, const std::string& column) const {
  std::vector<double> values;
  for (const RunResult* one : of)
    if (const std::optional<double> value = run_value(*one, column); value && !std::isnan(*value))
      values.push_back(*value);
  return values;
}

std::optional<double> RaceResults::value(const std::string& stack, const std::string& column, int run) const {
  if (run >= 0) {
    const std::vector<const RunResult*> mine = of(stack);
    return static_cast<std::size_t>(run) < mine.size() ? run_value(*mine[static_cast<std::size_t>(run)], column)
                                                       : std::nullopt;
  }
  if (const std::string of(interval_of(column)); !of.empty()) {
    const MedianInterval interval = bootstrap_median_interval(values_of(distinct(stack), of));
    const double end = column.ends_with("_lo") ? interval.lo : interval.hi;
    return std::isnan(end) ? std::nullopt : std::optional(end);
  }
  const std::optional<NamedColumn> named = find_race_column(column);
  if (!named) return std::nullopt;
  const RowSum sum = named->column->sum;
  std::vector<double> values = values_of(sum == RowSum::cost ? of(stack) : distinct(stack), column);
  if (values.empty() && (column == "solver_failures" || sum == RowSum::median || sum == RowSum::largest))
    return std::nullopt;
  if (sum == RowSum::median) return gripline::median(std::move(values));
  if (sum == RowSum::largest) return *std::max_element(values.begin(), values.end());
  return std::accumulate(values.begin(), values.end(), 0.0);
}

std::size_t RaceResults::most_laps() const {
  std::size_t most = 0;
  for (const RunResult& run : runs) most = std::max(most, run.summary.laps.size());
  return most;
}

std::vector<std::string> interval_columns(const RaceResults& results) {
  const std::size_t laps = std::max(results.most_laps(), static_cast<std::size_t>(results.race.world.laps));
  std::vector<std::string> columns = race_column_names("table.csv", laps);
  std::erase_if(columns, [](const std::string& column) { return !is_table_column(column + "_lo"); });
  return columns;
}

}  // namespace gripline
