// runs.csv, table.csv and claims.json of a race, and the table as people read it.
#pragma once

#include <filesystem>
#include <iosfwd>
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
};

/// The columns of table.csv that have COLUMN_lo and COLUMN_hi.
std::vector<std::string> interval_columns(const RaceResults& results);

/// A number in printf's format, "-" when there is none.
std::string cell_text(const std::optional<double>& value, const char* pattern);
/// Columns right-aligned, the first one left.
void print_aligned(std::ostream& out, const std::vector<std::vector<std::string>>& rows);

/// Flying laps of runs that never left the road (with the centre of gravity, with the whole car) and are faster than
/// the world's limit for that by more than its stated error, one line each: they show that the limit is wrong. Laps of
/// changing friction are compared at their mean factor.
std::vector<std::string> beaten_limits(const RaceResults& results);

/// Why a claim on times is skipped.
inline constexpr const char* times_not_alone = "on times: needs -j 1";
/// Claims about rows left out are skipped, and those on times unless every run of their rows was driven alone.
std::vector<ClaimResult> judge_all(const RaceResults& results);

/// Throws std::runtime_error when the disk refuses.
void write_claims(const std::filesystem::path& out, std::span<const ClaimResult> claims);
void write_tables(const std::filesystem::path& out, const RaceResults& results, std::span<const ClaimResult> claims);
void print_tables(std::ostream& out, const RaceResults& results, std::span<const ClaimResult> claims);

}  // namespace gripline
