// The runs of a results folder that are exported.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "report/columns.hpp"

namespace gripline::exports {

/// Which runs: no names mean every row, no seeds the first one of each row.
struct RunFilter {
  std::vector<std::string> stacks, seeds;
};

/// A run, named by its row; "row/seed" where several seeds of it are exported.
struct NamedRun {
  std::string name;
  report::Columns steps;  ///< steps.csv (framework/doc/output.md)
};

struct Results {
  nlohmann::json scene;   ///< scene.json; null if absent
  report::Columns track;  ///< track.csv; empty if absent
  std::vector<NamedRun> runs;
};

/// Reads them. Throws InputError where the folder holds no results, or none of those that are asked for.
Results read_results(const std::filesystem::path& folder, const RunFilter& filter);

}  // namespace gripline::exports
