// The result of one run, as files keep it: summary.json and what timing.csv adds.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "race/metrics.hpp"

namespace gripline {

/// CPU times of a run, from timing.csv.
struct RunTiming {
  double solve_ms_median = 0, solve_ms_p95 = 0, solve_ms_p99 = 0, update_ms_median = 0, cpu_s = 0;
  bool alone = false;  // no other run was driven at the same time; false where that is not known
};

struct RunResult {
  RunSummary summary;
  RunTiming timing;
  std::optional<std::uint64_t> driven_as;  // the seed whose run this is: it was not driven again
  std::string drive;  // hash of steps.csv; two runs that have the same did the same to the last bit. Empty: not known
};

/// Writes summary.json into the run's folder, with the key that names the run's inputs, the SHA-256 of every result
/// there that comes out the same each time, and its own. The times of timing.csv do not, and the same run gives the
/// same summary: its hash stands in timing.sha256, as `sha256sum` writes it, under a comment that says whether the run
/// was alone (RunTiming). Throws std::runtime_error.
void write_summary(const std::filesystem::path& folder, const RunSummary& summary, const std::string& key,
                   bool alone = false);

/// The summary of a run that was not driven because it would equal `driven` to the last bit; the folder has no more.
/// Of a copy the summary names the run that was driven: only that one has files.
void write_copied_summary(const std::filesystem::path& folder, const RunResult& driven, std::uint64_t seed,
                          const std::string& key);

/// What a run's folder holds, if it was finished with this key (any key when empty) and every file is still the one
/// that was written then. `damage`, when asked for, says what is not, and is empty otherwise.
std::optional<RunResult> read_result(const std::filesystem::path& folder, const std::string& key,
                                     std::string* damage = nullptr);

}  // namespace gripline
