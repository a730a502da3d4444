// The heading that a map in the making has, and which column follows its turning.
#pragma once

#include "measured/session/guess_draft.hpp"
#include "measured/session/session_windows.hpp"

namespace gripline::measured {

/// Of a column's mean and the heading's change per row, over so many rows that the change is more than noise; without
/// pairs where the map has no yaw yet.
Correlation heading_follows(const GuessDraft& draft, int column);

}  // namespace gripline::measured
