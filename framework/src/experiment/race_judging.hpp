// What the results of a race say of its claims, and of the world's limits.
#pragma once

#include <string>
#include <vector>

#include "experiment/race_results.hpp"

namespace gripline {

/// Flying laps of runs that never left the road (with the centre of gravity, with the whole car) and are faster than
/// the world's limit for that by more than its stated error, one line each: they show that the limit is wrong. Laps of
/// changing friction are compared at their mean factor.
std::vector<std::string> beaten_limits(const RaceResults& results);

/// Why a claim on times is skipped.
inline constexpr const char* times_not_alone = "on times: needs -j 1";
/// Claims about rows left out are skipped, and those on times unless every run of their rows was driven alone.
std::vector<ClaimResult> judge_all(const RaceResults& results);

}  // namespace gripline
