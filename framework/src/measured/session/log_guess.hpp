// A first map for a logger's table: columns by their names and units, then checked against what they show.
#pragma once

#include <string>
#include <vector>

#include "config/node.hpp"
#include "tables/delimited_table.hpp"

namespace gripline::measured {

struct Guess {
  Node map;                          // as log_map.hpp describes; every delay "find"
  std::vector<std::string> remarks;  // what was concluded from the numbers, and what is in doubt
  std::vector<std::string> open;     // channels that are needed and no column looks like: "column": "?" in the map
};

Guess guess_map(const DelimitedTable& table);

}  // namespace gripline::measured
