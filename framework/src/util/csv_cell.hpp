// Text as one cell of a CSV file.
#pragma once

#include <string>
#include <string_view>

namespace gripline {

/// Quoted (RFC 4180) when it holds a comma, a quote or the end of a line, else as it is.
std::string csv_cell(std::string_view text);

}  // namespace gripline
