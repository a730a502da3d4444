#pragma once
#include <cstddef>
#include <memory>
#include <string_view>

#include "config/node.hpp"

namespace gripline {

/// What was read so far of what json_limits allows.
struct JsonBudget {
  std::size_t values = 0, pointers = 0;
};

/// The grammar behind parse_text(): strict JSON with a place for every value. Counts into `budget`. Throws InputError.
[[nodiscard]] Node parse_json(std::string_view text, std::shared_ptr<const Source> source, JsonBudget& budget);

}  // namespace gripline
