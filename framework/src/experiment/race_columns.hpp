// The columns of runs.csv and table.csv that are measured: what each is, how it is read from a run and how a row of
// table.csv sums it up over its runs. Once, for the tables, for claims about them and for their documentation.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "experiment/run_result.hpp"
#include "world/world_spec.hpp"

namespace gripline {

/// How a row of table.csv sums up a column over its runs. `total` adds and counts equal runs once; `cost` adds and
/// counts a run as often as it was driven.
enum class RowSum { median, total, cost, largest };

struct RaceColumn {
  const char* files;  ///< "runs.csv table.csv sweep", any of them: sweep for the records of a sweep; "": claims only
  const char* name;   ///< K stands for a lap, counted from 0
  const char* unit;
  RowSum sum;
  bool has_interval;  ///< table.csv has the ends of a bootstrap interval of its median, NAME_lo and NAME_hi
  const char* meaning;
  /// What the run measured, if it did. `lap` is that of the name, 0 for a column without one.
  std::optional<double> (*read)(const WorldSpec& world, const RunResult& run, std::size_t lap);
};

/// In the order of the files' headers.
std::span<const RaceColumn> race_columns();

struct NamedColumn {
  const RaceColumn* column;
  std::size_t lap;
};
/// The column that a name such as "lap12_s" means; empty when there is none, nor for the ends of intervals.
std::optional<NamedColumn> find_race_column(std::string_view name);

/// The header's names of the columns that stand in `file`, those of laps for `laps` laps each.
std::vector<std::string> race_column_names(std::string_view file, std::size_t laps);

/// The columns that a sweep records of a run, those that come out the same each time: "finished", then lap by lap those
/// of laps, then the others.
std::vector<std::string> recorded_columns(std::size_t laps);

/// The column whose interval `name` is an end of ("lap1_s" for "lap1_s_lo", "lap1_s_hi"); empty when it is not one.
std::string_view interval_of(std::string_view name);

/// Whether claims may name it: a column, or an end of an interval of one that has it.
bool is_table_column(std::string_view name);

}  // namespace gripline
