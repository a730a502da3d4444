// Rows of a race against a baseline row, draw by draw: pairs.csv and the same as people read it.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "experiment/race_results.hpp"

namespace gripline {

/// A column of a stack minus that of the baseline under the same seed, over the seeds at which both have it.
struct PairedDifference {
  std::string stack, column;
  std::optional<double> difference;  // median
  std::optional<double> lo, hi;      // bootstrap_median_interval; empty for fewer than two draws
  double p = 1.0;                    // sign_test: that plus and minus are alike
  int draws = 0;                     // that differ; those equal to the last bit in both rows count once
};

/// Every row but the baseline, every column of table.csv that has an interval, and seconds outside.
std::vector<PairedDifference> paired_differences(const RaceResults& results, const std::string& baseline);

/// Throws std::runtime_error when the disk refuses.
void write_pairs(const std::filesystem::path& out, const std::string& baseline,
                 std::span<const PairedDifference> pairs);
void print_pairs(std::ostream& out, const std::string& baseline, std::span<const PairedDifference> pairs);

}  // namespace gripline
