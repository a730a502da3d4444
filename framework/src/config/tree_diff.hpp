// What differs between two trees, for people.
#pragma once

#include <string>
#include <vector>

#include "config/node.hpp"

namespace gripline {

/// One line per difference, in the order of `after` and then of what is gone: "/seeds/count: 2 -> 3",
/// "/stacks/b: new", "/stacks/c: gone". Members called "note" and nulls are not differences.
[[nodiscard]] std::vector<std::string> differences(const Node& before, const Node& after);

}  // namespace gripline
