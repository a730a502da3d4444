// Topics of a bag as one table: a column for each number that is asked for, "/odom.pose.pose.position.x", a row for
// each message of one topic, whose times are the column "time".
#pragma once

#include <string>
#include <vector>

#include "bags/bag_file.hpp"
#include "measured/session/log_map.hpp"
#include "tables/delimited_table.hpp"

namespace gripline::bags {

inline constexpr const char* time_column = "time";

/// A number that is asked for.
struct Wanted {
  std::string column;  // "/topic.member.member[3]"
  bool held = false;   // between messages the last one's; else linear from one to the next
  bool wraps = false;  // an angle whose jumps from one end of its range to the other are not bridged
  Origin origin{};     // of the map's channel
};

/// The table of these columns. Rows are the messages of `options.rows`, else of the topic with most messages among
/// those used. Times are those of headers where they make sense (rising, near the time of recording), else of
/// recording, in seconds from the first message of the bag on. Where a topic is silent for long (4 of its usual
/// intervals, 0.25 s at least) nothing is drawn between; what is held goes on. `most_numbers`: where reading ends
/// [numbers]; said in the table's `found`.
/// Throws InputError: unknown topics and members (with the nearest name), a topic of a type that nobody defines,
/// messages that are not what their type says.
DelimitedTable read_table(BagFile& bag, const std::vector<Wanted>& wanted, const measured::BagOptions& options,
                          std::size_t most_numbers = SIZE_MAX);

/// What a map's formulas name in backquotes, each column once. Throws InputError when one column is wanted held and
/// linear.
std::vector<Wanted> wanted_by(const measured::LogMap& map);

/// The table that a map reads.
DelimitedTable read_table(BagFile& bag, const measured::LogMap& map);

/// Definitions that a bag's own lacks: common ones, and those of the folder that the options name.
Definitions definitions_for(const measured::BagOptions& options);
/// What a topic's messages hold. Throws InputError.
Schema schema_of(const BagFile& bag, const Topic& topic, const Definitions& others);

}  // namespace gripline::bags
