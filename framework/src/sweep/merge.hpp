// One table of all records of a sweep, and what is missing or broke.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sweep/store.hpp"
#include "sweep/sweep.hpp"

namespace gripline::sweep {

struct MergeOutcome {
  std::size_t runs = 0, finished = 0, broken = 0, missing = 0;
  double cpu_s = 0;  // of all runs
  bool complete() const { return missing == 0; }
};

/// What the statistics read: the runs that are in the table, in the order of their numbers.
struct Table {
  std::vector<std::string> factors;               // names: "experiment", pointers, "stack"
  std::vector<std::vector<std::string>> levels;   // by factor, in the order of first appearance
  std::vector<std::vector<std::uint32_t>> level;  // by factor and row: index into levels
  std::vector<std::uint64_t> seed;                // by row
  std::vector<std::uint64_t> drive;               // by row: what it did, as a number; 0 is not known
  std::vector<bool> repeats;                      // by row: equals an earlier one of its setting to the last bit
  std::vector<bool> broken;                       // by row: it did not come to its end
  std::vector<std::string> responses;             // columns of numbers
  std::vector<std::vector<double>> value;         // by response and row, NaN where there is none
  std::size_t rows() const { return seed.size(); }
  /// A value that counts: what a run that broke had done until then says nothing but that it did not finish.
  double counted(std::size_t response, std::size_t row) const;
};

/// Writes OUT/table.csv (one row per run that has a record: equal bytes however and wherever the runs were made),
/// OUT/timing.csv (times and machines, which differ) and OUT/missing.csv (run, experiment, setting, stack, seed, what,
/// message of those that are missing or broke). `progress(done, total)` may be empty. Throws std::runtime_error.
MergeOutcome merge_records(const std::filesystem::path& out, const Sweep& sweep, Table& table,
                           const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace gripline::sweep
