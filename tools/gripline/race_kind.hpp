// Experiments of kind "race", for compare and for run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "experiment/experiment.hpp"
#include "gripline/experiment_kinds.hpp"
#include "plugin/registry.hpp"

namespace gripline::tools {

/// Throws InputError with the nearest name when the race has no such stack.
void require_stack(const RaceSpec& race, const std::string& name);
/// Rows in the order of the experiment, whatever the order asked for; all when none is. Throws InputError.
std::vector<std::string> chosen_rows(const RaceSpec& race, const std::vector<std::string>& only);

/// What is allowed but was most likely not meant (world/plausibility.hpp, experiment/race_warnings.hpp): of the world, of
/// these stacks, and of the claims where they are asked about.
std::vector<Diagnostic> race_warnings(const RaceSpec& race, const std::vector<std::string>& stacks, bool judged);

/// The runs that are asked for.
struct RunSelection {
  std::vector<std::string> stacks;
  std::vector<std::uint64_t> seeds;
  bool judged = true;         // are claims asked about?
  std::string baseline = {};  // the row that others are compared with; empty: none
};
/// Races them, writes and prints tables and report. Returns the program's exit code.
int race_and_report(const RaceSpec& race, const RunSelection& chosen, const Registry& registry,
                    const ExperimentRequest& request);

}  // namespace gripline::tools
