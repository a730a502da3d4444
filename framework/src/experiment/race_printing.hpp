// The table of a race as people read it.
#pragma once

#include <iosfwd>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "experiment/race_results.hpp"

namespace gripline {

/// A number in printf's format, "-" when there is none.
std::string cell_text(const std::optional<double>& value, const char* pattern);
/// Columns right-aligned, the first one left.
void print_aligned(std::ostream& out, const std::vector<std::vector<std::string>>& rows);

void print_tables(std::ostream& out, const RaceResults& results, std::span<const ClaimResult> claims);

}  // namespace gripline
