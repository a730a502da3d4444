// All runs in one table, as PlotJuggler and spreadsheets open it: one row an instant, one column a quantity of a run.
#pragma once

#include <span>
#include <string>

#include "exports/runs.hpp"

namespace gripline::exports {

/// First column t_s, then `row/column` for every column of every steps.csv. Instants of runs that are less than 1 µs apart are
/// one row; cells of a run that has no step then are empty.
std::string wide_csv(std::span<const NamedRun> runs);

}  // namespace gripline::exports
