// Tables of numbers as people read them in a terminal.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace gripline {

/// A number in printf's format, "-" when there is none.
std::string cell_text(const std::optional<double>& value, const char* pattern);
/// Columns right-aligned, the first one left.
void print_aligned(std::ostream& out, const std::vector<std::vector<std::string>>& rows);

}  // namespace gripline
