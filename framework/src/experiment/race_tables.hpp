// runs.csv, table.csv and claims.json of a race.
#pragma once

#include <filesystem>
#include <span>

#include "experiment/race_results.hpp"

namespace gripline {

/// Throws std::runtime_error when the disk refuses.
void write_claims(const std::filesystem::path& out, std::span<const ClaimResult> claims);
void write_tables(const std::filesystem::path& out, const RaceResults& results, std::span<const ClaimResult> claims);

}  // namespace gripline
