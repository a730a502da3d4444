// What one cell of a logger's table says: a number, a truth value, a time, or no value.
#pragma once

#include <string_view>

namespace gripline {

/// Without blanks, tabs, carriage returns and no-break spaces (UTF-8) at both ends.
std::string_view trim_cell(std::string_view text);

/// Whether a trimmed cell says that there is nothing: empty, "-", "NaN", "N/A" and their like.
bool is_missing(std::string_view cell);

/// A number as people write it: "1.5", "1,5" with `decimal_comma`; 1 and 0 of "true" and "false"; seconds of "1:02.5",
/// and since 1970 of "2018-04-08T10:31:37+02:00" (ISO 8601). NaN when it is none of these, or not finite.
double read_cell(std::string_view cell, bool decimal_comma);

}  // namespace gripline
