// runs.csv, table.csv and claims.json of a race, and the table as people read it.
#pragma once

#include <filesystem>
#include <iosfwd>
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
  /// The value of a column of table.csv for a stack: one run's, or the stack's when run is -1.
  std::optional<double> value(const std::string& stack, const std::string& column, int run) const;
};

/// Claims about rows left out are skipped, and those on times unless `alone` (runs did not share the machine).
std::vector<ClaimResult> judge_all(const RaceResults& results, bool alone);

/// Throws std::runtime_error when the disk refuses.
void write_claims(const std::filesystem::path& out, std::span<const ClaimResult> claims);
void write_tables(const std::filesystem::path& out, const RaceResults& results, std::span<const ClaimResult> claims);
void print_tables(std::ostream& out, const RaceResults& results, std::span<const ClaimResult> claims);

}  // namespace gripline
