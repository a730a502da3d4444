// All runs in one table for PlotJuggler and spreadsheets: one row per instant, one column per quantity and run.
#pragma once

#include <span>
#include <string>

#include "exports/runs.hpp"

namespace gripline::exports {

/// First column t_s, then `row/column` for every column of every steps.csv. Instants less than 1 µs apart share a row;
/// cells of a run that has no step at that instant are empty.
std::string wide_csv(std::span<const NamedRun> runs);

}  // namespace gripline::exports
