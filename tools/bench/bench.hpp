// How long the steps of a stack take: recorded instances, replayed to every controller in one process.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "plugin/registry.hpp"
#include "util/progress.hpp"
#include "world/world_spec.hpp"

namespace gripline {

/// One case. Times are thread CPU time per control step [us]; an error is a share of the input's range, against the
/// same problem solved by Ipopt to 1e-10; NaN where a figure has no meaning.
struct BenchRow {
  std::string name;
  double median_us = 0, p95_us = 0, p99_us = 0, max_us = 0;
  double allocations_per_step = 0, iterations_median = 0, first_input_error_p95 = 0, first_input_error_max = 0;
  int failures = 0;
  double ratio_to_mpc_ipopt = 0;
};

/// Number of heap allocations of this process so far; supplied by the program, which replaces malloc.
using AllocationCount = std::int64_t (*)();

struct BenchOptions {
  int instances = 200;                                              // recorded problems
  std::vector<std::string> controllers = {"mpc_ipopt", "mpc_sqp"};  // ids; all take mpc_sqp's cost parameters
};

/// Drives a lap and a half in this world with a learning stack, freezes what it learned, records consecutive problems
/// and replays them three times to each controller in turn. A step's work is the same in each replay, so its least time
/// counts. Cases named elm40 include learning: the update of a copy of the estimator that keeps learning.
std::vector<BenchRow> run_bench(const WorldSpec& world, const Registry& registry, AllocationCount allocations,
                                const BenchOptions& options, const ProgressCallback& progress = {});

void write_bench(const std::filesystem::path& file, std::span<const BenchRow> rows);

}  // namespace gripline
