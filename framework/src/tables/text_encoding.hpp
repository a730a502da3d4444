// Tables as spreadsheets save them, in UTF-8.
#pragma once

#include <string>

namespace gripline {

/// Lines that are not UTF-8 are read as Windows-1252, as Excel writes a CSV ("\xb0" is a degree sign); bytes that it
/// does not have become U+FFFD. Returns whether there were any. Line by line: of a file that was cut off, the rest
/// stays as it is.
bool to_utf8(std::string& text);

}  // namespace gripline
