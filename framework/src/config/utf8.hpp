// Whether a text is UTF-8.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace gripline {

/// Where the first byte stands that is not part of well-formed UTF-8 (RFC 3629), if there is one.
[[nodiscard]] std::optional<std::size_t> find_malformed_utf8(std::string_view text);

}  // namespace gripline
