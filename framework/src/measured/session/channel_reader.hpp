// The values that a map makes of a table's columns, in SI.
#pragma once

#include <set>
#include <vector>

#include "measured/finding.hpp"
#include "measured/session/log_map.hpp"
#include "measured/table/formula.hpp"
#include "tables/delimited_table.hpp"

namespace gripline::measured {

/// By row of the table, NaN where a cell is missing or no number.
struct ChannelValues {
  std::vector<double> value;
  bool unit_of_header = false;  // the table's header, not the map, says in which unit the numbers are
};

/// Reads channel by channel. Findings are of columns in which text stands for numbers (said once) and of units of the
/// header that are none of the channel's kind.
class ChannelReader {
 public:
  /// All three outlive it.
  ChannelReader(const DelimitedTable& table, const LogMap& map, std::vector<Finding>& findings)
      : table_(table), map_(map), findings_(findings) {}

  /// In `unit`, with the map's sign. `name` is what the channel is called in messages, "time" for the time; `time` [s]
  /// is that of the rows, or empty while it is not known. Throws InputError, at the map's line where there is one: a
  /// formula that cannot be read; a column that stands twice, or without a number.
  ChannelValues read(const MappedChannel& channel, const char* unit, const char* name, const std::vector<double>& time);

 private:
  struct Factor {
    double value = 1.0;
    bool of_header = false;
  };
  Factor factor_of(const MappedChannel& channel, const char* unit, const Formula& formula);
  void check_cells(std::size_t column, bool of_time);
  void check_name(std::size_t column) const;
  void note(std::string check, std::string found, std::string done);

  const DelimitedTable& table_;
  const LogMap& map_;
  std::vector<Finding>& findings_;
  std::set<std::size_t> reported_;  // columns of which it is said that cells are not numbers
};

}  // namespace gripline::measured
