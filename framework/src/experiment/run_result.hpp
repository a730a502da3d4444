// The result of one run, as files keep it: summary.json and what timing.csv adds.
#pragma once

#include <filesystem>
#include <optional>

#include "race/metrics.hpp"

namespace gripline {

/// CPU times of a run, from timing.csv.
struct RunTiming {
  double solve_ms_median = 0, solve_ms_p95 = 0, solve_ms_p99 = 0, update_ms_median = 0, cpu_s = 0;
};

struct RunResult {
  RunSummary summary;
  RunTiming timing;
};

/// Writes summary.json into the run's folder, with the key that names the run's inputs. Throws std::runtime_error.
void write_summary(const std::filesystem::path& folder, const RunSummary& summary, const std::string& key);

/// What a run's folder holds, if it was finished with this key (any key when empty).
std::optional<RunResult> read_result(const std::filesystem::path& folder, const std::string& key);

}  // namespace gripline
