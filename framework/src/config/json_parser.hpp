#pragma once
#include <memory>
#include <string_view>

#include "config/node.hpp"

namespace gripline {

/// The grammar behind parse_text(): strict JSON with a place for every value. Throws InputError.
[[nodiscard]] Node parse_json(std::string_view text, std::shared_ptr<const Source> source);

}  // namespace gripline
