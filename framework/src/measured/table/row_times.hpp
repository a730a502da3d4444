// Which rows of a logger's table are samples, and when they were taken.
#pragma once

#include <cstddef>
#include <vector>

#include "measured/finding.hpp"
#include "tables/delimited_table.hpp"

namespace gripline::measured {

struct RowTimes {
  std::vector<std::size_t> row;  // of the table, in the order of time
  std::vector<double> t;         // of each [s], in the log's own clock
  double step = 0;               // median of what lies between two [s]
};

/// Rows by their times [s], NaN where a row has none: those are left out, as are a few before a clock was set. Rows of
/// one time stamp become one in the table and in `time`. `of_clock`: times are written as 12:34.5 or as a date. Says in
/// `findings` what it left out. Throws InputError: fewer than 20 rows, time that runs backward, steps by more than an
/// hour, is not in seconds, or has rows more than 0.5 s apart.
RowTimes order_rows(DelimitedTable& table, std::vector<double>& time, bool of_clock, std::vector<Finding>& findings);

}  // namespace gripline::measured
