#include "measured/table/row_times.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "measured/clock_steps.hpp"
#include "tables/refuse_file.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

using Values = std::vector<double>;
using Rows = std::vector<std::size_t>;

void note_rows(std::vector<Finding>& findings, std::string found, std::string done) {
  findings.push_back({Finding::Level::note, "rows", std::move(found), std::move(done)});
}

/// Loggers of several buses write a row for each message. Of every column the first cell that holds a number counts.
void merge_repeated_rows(DelimitedTable& table, Values& time, std::vector<Finding>& findings) {
  Rows kept;
  std::size_t again = 0, last = table.rows();  // the last row that has a time
  for (std::size_t r = 0; r < table.rows(); ++r) {
    if (last < r && time[r] == time[last]) {
      ++again;
      for (Values& column : table.column)
        if (std::isnan(column[last])) column[last] = column[r];
      continue;
    }
    if (!std::isnan(time[r])) last = r;
    kept.push_back(r);
  }
  if (again == 0) return;
  const auto compact = [&](auto& all) {
    for (std::size_t i = 0; i < kept.size(); ++i) all[i] = all[kept[i]];
    all.resize(kept.size());
  };
  for (Values& column : table.column) compact(column);
  compact(table.line);
  compact(time);
  note_rows(findings, std::to_string(again) + " repeat a time stamp",
            "they fill the empty cells of the first row of it");
}

Rows rows_with_time(const DelimitedTable& table, const Values& time, std::vector<Finding>& findings) {
  Rows rows;
  for (std::size_t r = 0; r < table.rows(); ++r) {
    const double t = time[r], last = rows.empty() ? t : time[rows.back()];
    if (std::isnan(t)) continue;
    if (t < last)
      refuse_file(table.file,
                  "time runs backward by " + significant(last - t) + " s, from " + significant(last, 16) + " s to " +
                      significant(t, 16) +
                      " s; expected rows in the order of time (sort them, or cut the log where its clock was set)",
                  table.line[r]);
    rows.push_back(r);
  }
  if (rows.size() < table.rows())
    note_rows(findings, std::to_string(table.rows() - rows.size()) + " without time", "left out");
  constexpr std::size_t fewest = 20;
  if (rows.size() < fewest)
    refuse_file(table.file, "only " + std::to_string(rows.size()) + " rows with a time; expected " +
                                std::to_string(fewest) + " or more, and 60 s are good");
  return rows;
}

/// Median of the steps; the mean where rows of a bus come in bursts.
double step_between(const Rows& rows, const Values& time) {
  Values steps;
  for (std::size_t i = 1; i < rows.size(); ++i) steps.push_back(time[rows[i]] - time[rows[i - 1]]);
  const double step = median(steps);
  return step >= shortest_step ? step : mean_step(steps);
}

void check_unit(const DelimitedTable& table, double step) {
  if (may_be_seconds_or_milliseconds(step))
    refuse_file(table.file, "rows are " + significant(step) + " s apart (" + significant(1.0 / step) +
                                " Hz); expected 0.5 s or less (2 Hz); if the numbers are milliseconds (" +
                                significant(1e3 / step, 4) + " Hz), the map should say so (\"unit\": \"ms\")");
  for (const auto& [unit, factor] : {std::pair("milliseconds", 1e-3), {"microseconds", 1e-6}, {"nanoseconds", 1e-9}})
    if (step >= least_count && step * factor >= 0.9e-3 && step * factor < 0.9)
      refuse_file(table.file, "time rises by " + significant(step) + " s from row to row: it looks like " + unit +
                                  "; the map should say so (\"unit\")");
}

void check_step(const DelimitedTable& table, double step, bool of_clock) {
  if (!of_clock) check_unit(table, step);
  for (const auto& [unit, factor] : {std::pair("milliseconds", 1e3), {"microseconds", 1e6}, {"nanoseconds", 1e9}})
    if (step < shortest_step && step * factor > 0.9e-3 && step * factor < 0.3)
      refuse_file(table.file, "rows are " + significant(step) +
                                  " s apart, which no logger writes: time was taken for " + unit + " and is seconds");
  if (step > 0.5)
    refuse_file(table.file, "rows are " + significant(step) + " s apart (" + significant(1.0 / step) +
                                " Hz); expected 0.5 s or less (2 Hz)");
}

/// A step beyond an hour is a clock that was set, as by the first fix of a receiver. A few rows before it are left
/// out; elsewhere it is refused, for everything that lies on a grid of time would fill memory with the step.
void drop_rows_before_clock_was_set(const DelimitedTable& table, const Values& time, Rows& rows,
                                    std::vector<Finding>& findings) {
  std::size_t leading = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double step = time[rows[i]] - time[rows[i - 1]];
    if (!(step > longest_step)) continue;
    if (100 * i >= rows.size())
      refuse_file(table.file,
                  "time steps by " + significant(step) +
                      " s, more than an hour: the clock was set here, or the car stood; cut the log in two before "
                      "this row",
                  table.line[rows[i]]);
    leading = i;
  }
  if (leading == 0) return;
  rows.erase(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(leading));
  note_rows(findings, std::to_string(leading) + " before the clock was set", "left out");
}

}  // namespace

RowTimes order_rows(DelimitedTable& table, std::vector<double>& time, bool of_clock, std::vector<Finding>& findings) {
  merge_repeated_rows(table, time, findings);
  RowTimes out;
  out.row = rows_with_time(table, time, findings);
  out.step = step_between(out.row, time);
  check_step(table, out.step, of_clock);
  drop_rows_before_clock_was_set(table, time, out.row, findings);
  for (const std::size_t r : out.row) out.t.push_back(time[r]);
  return out;
}

}  // namespace gripline::measured
