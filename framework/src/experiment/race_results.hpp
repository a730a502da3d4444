// The results of a race: its runs, and the values of their rows in its tables.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiment/experiment.hpp"
#include "experiment/run_result.hpp"

namespace gripline {

/// Results in the order stacks x seeds; a run that never ended has status error.
struct RaceResults {
  const RaceSpec& race;
  std::vector<RunResult> runs;
  std::vector<std::string> rows;  // the stacks that were asked for (--only)

  std::vector<const RunResult*> of(const std::string& stack) const;
  /// The runs of a stack; of those that drove the same to the last bit, only the first.
  std::vector<const RunResult*> distinct(const std::string& stack) const;
  /// The value of a column of table.csv for a stack: one run's, or the stack's when run is -1.
  std::optional<double> value(const std::string& stack, const std::string& column, int run) const;
  std::optional<double> run_value(const RunResult& run, const std::string& column) const;
  /// What some of the runs have of a column: those without a number are left out.
  std::vector<double> values_of(const std::vector<const RunResult*>& of, const std::string& column) const;
  /// Laps of the run that drove most of them.
  std::size_t most_laps() const;
};

/// The columns of table.csv that have COLUMN_lo and COLUMN_hi.
std::vector<std::string> interval_columns(const RaceResults& results);

}  // namespace gripline
