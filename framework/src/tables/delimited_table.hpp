// Tables of numbers as loggers and spreadsheets write them: preambles, a row of units, any separator, decimal commas,
// comment lines, quoted cells. Reads what util/csv.hpp refuses on purpose, and reports it in `found`.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace gripline {

struct DelimitedTable {
  /// Cells of a column in which something stands that is not a number.
  struct Unread {
    std::size_t cells = 0;
    std::string first;
    int line = 0;  // of the first, in the file
  };
  std::filesystem::path file;
  std::vector<std::string> name;     // of the columns, without unit; unique: the second "a" is "a_2"
  std::vector<std::string> unit;     // "" where none is written
  std::vector<std::string> meaning;  // what the source says a column is, for a guess; empty: only the names are known
  std::vector<std::vector<double>> column;  // NaN where a cell is empty or no number
  std::vector<bool> of_clock;               // written as 12:34.5 or as a date, which is seconds; may be empty
  std::vector<Unread> unread;               // by column; may be empty
  std::vector<int> line;                    // of the file, by row, from 1
  std::vector<std::string> found;           // what was unusual, one sentence each
  std::vector<std::string> repeated;        // names that stand more than once in the header
  bool unit_row = false;                    // units stand in a row of their own
  int header_line = 0;                      // of the names, in the file, from 1; 0: not from a text
  int other_length = 0;                     // line of the first row of another length, which is left out; 0: none

  std::size_t rows() const { return line.size(); }
  bool is_clock(std::size_t c) const { return c < of_clock.size() && of_clock[c]; }
  /// Index of a column by its name (upper and lower case differ), or -1.
  int find(std::string_view name) const;
};

/// Reads a text table. The separator (comma, semicolon, tab, vertical bar or blanks) is the one that makes most lines
/// equally long; lines before the header, lines that begin with '#', "//" or '%' and rows of another length are left
/// out; rows that lack less than half of their cells have empty ones there. A header may begin with '#'; units stand in
/// a row of their own (perhaps behind '#') or behind the name, as "Speed (km/h)" or "Speed [km/h]". true and false are
/// 1 and 0; "12:34.5" and "1:12:34.5" are seconds. Lines that are not UTF-8 are read as Windows-1252.
/// Throws InputError: no such file, not a text, no row of numbers, no header (then names as in `example` are expected).
DelimitedTable read_delimited(const std::filesystem::path& file, std::string_view example = {});

}  // namespace gripline
