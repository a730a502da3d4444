// The table of a race as people read it.
#pragma once

#include <iosfwd>
#include <span>

#include "experiment/race_results.hpp"

namespace gripline {

void print_tables(std::ostream& out, const RaceResults& results, std::span<const ClaimResult> claims);

}  // namespace gripline
