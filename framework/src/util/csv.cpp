#include "util/csv.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <span>

#include "config/ascii.hpp"
#include "config/errors.hpp"
#include "config/files.hpp"
#include "util/numbers.hpp"

namespace gripline {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, int line, int column, std::string message) {
  throw InputError({Diagnostic{file.string(), line, column, "", std::move(message), {}}});
}

/// A line as it stands in the file; places in it are counted in characters from 1, as editors do.
struct CsvLine {
  std::string_view raw;
  int number = 0;
  int column(const char* at) const {
    return 1 + static_cast<int>(std::count_if(raw.data(), at, [](char c) { return (c & 0xc0) != 0x80; }));
  }
};

/// Cells of one line; each is a part of it.
void split(std::string_view line, std::vector<std::string_view>& cells) {
  cells.clear();
  std::size_t begin = 0;
  while (true) {
    const std::size_t comma = line.find(',', begin);
    const std::size_t end = comma == std::string_view::npos ? line.size() : comma;
    cells.push_back(trim(line.substr(begin, end - begin)));
    if (comma == std::string_view::npos) return;
    begin = comma + 1;
  }
}

double parse(const std::filesystem::path& file, const CsvLine& line, std::string_view cell, bool allow_missing) {
  const bool missing = cell.empty() || cell == "nan" || cell == "NaN";
  if (missing && allow_missing) return not_a_number;
  double number = 0.0;
  const char* const end = cell.data() + cell.size();
  // std::from_chars knows no '+'.
  const bool plus = cell.size() > 1 && cell.front() == '+' && cell[1] != '-';
  const auto [stop, code] = std::from_chars(cell.data() + (plus ? 1 : 0), end, number);
  if (code != std::errc() || stop != end || !std::isfinite(number)) {
    const std::size_t semicolon = cell.find(';');
    if (semicolon != std::string_view::npos)
      refuse(file, line.number, line.column(cell.data() + semicolon),
             "columns are separated by ';' here; expected ',' between columns and '.' as the decimal sign");
    refuse(file, line.number, line.column(cell.data()),
           "expected a finite number, found \"" + std::string(cell) + "\"");
  }
  return number;
}

/// Whether a row is the last one, before this `rest` of a file, and ends early: cells are missing or a number's end.
bool is_cut(const std::vector<std::string_view>& cells, std::size_t columns, std::string_view rest) {
  constexpr std::string_view blanks = " \t\r\n", unfinished = "+-eE";
  if (rest.find_first_not_of(blanks) != std::string_view::npos || cells.size() > columns) return false;
  return cells.size() < columns || (!cells.back().empty() && unfinished.find(cells.back().back()) != unfinished.npos);
}

/// Words, as a header has and no row.
bool are_names(const std::vector<std::string_view>& cells) {
  return std::ranges::all_of(cells, [](std::string_view cell) {
    const bool letter = !cell.empty() && std::isalpha(static_cast<unsigned char>(cell.front())) != 0;
    return letter && cell != "nan" && cell != "NaN" && cell != "inf";
  });
}

/// The names of columns that a first line behind '#' and those after it, `remarks`, have for a first row of these
/// cells: a remark may stand before them. Whether the row itself is the header.
bool find_header(CsvTable& table, const std::vector<std::string_view>& remarks,
                 const std::vector<std::string_view>& row) {
  const bool names = are_names(row);
  std::vector<std::string_view> cells = row;
  if (!names) {
    if (table.columns == row.size()) return false;
    const auto fits = [&](std::string_view remark) {
      split(trim(remark.substr(1)), cells);
      return cells.size() == row.size();
    };
    if (std::ranges::none_of(remarks, fits)) return false;
  }
  table.header.assign(cells.begin(), cells.end());
  table.columns = cells.size();
  return names;
}

}  // namespace

int CsvTable::find(std::string_view name) const {
  const auto found = std::find(header.begin(), header.end(), name);
  return found == header.end() ? -1 : static_cast<int>(found - header.begin());
}

std::vector<double> CsvTable::column(std::string_view name) const {
  const int index = find(name);
  if (index < 0) refuse(file, 1, 1, "no column \"" + std::string(name) + "\"" + did_you_mean(name, header));
  std::vector<double> out(rows());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = at(i, static_cast<std::size_t>(index));
  return out;
}

CsvTable read_csv(const std::filesystem::path& file, bool allow_missing, bool allow_cut) {
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  const std::string text = read_bytes(file);
  CsvTable table;
  table.file = file;
  std::vector<std::string_view> cells, remarks;  // remarks: from a header behind '#' to the first row
  bool sure = true;                              // which line is the header
  CsvLine line;
  std::string_view rest = text;
  if (rest.starts_with(byte_order_mark)) rest.remove_prefix(byte_order_mark.size());
  if (rest.starts_with("\xff\xfe") || rest.starts_with("\xfe\xff"))
    refuse(file, 1, 1, "is UTF-16; expected UTF-8 (iconv -f UTF-16 -t UTF-8)");
  if (rest.find('\n') == std::string_view::npos && trim(rest).find('\r') != std::string_view::npos)
    refuse(file, 1, 1, "lines end with carriage returns alone; expected newlines (tr '\\r' '\\n')");
  while (!rest.empty()) {
    const std::size_t newline = rest.find('\n');
    line.raw = rest.substr(0, newline);
    rest.remove_prefix(newline == std::string_view::npos ? rest.size() : newline + 1);
    ++line.number;
    std::string_view words = trim(line.raw);
    if (words.empty()) continue;
    if (table.header.empty()) {
      sure = words.front() != '#';
      if (!sure) words = trim(words.substr(1));
      if (const std::size_t semicolon = words.find(';'); semicolon != std::string_view::npos)
        refuse(file, line.number, line.column(words.data() + semicolon),
               "columns are separated by ';' here; expected ','");
      if (words.find(',') == std::string_view::npos)
        if (const std::size_t tab = words.find('\t'); tab != std::string_view::npos)
          refuse(file, line.number, line.column(words.data() + tab),
                 "columns are separated by tabs here; expected ','");
      split(words, cells);
      table.header.assign(cells.begin(), cells.end());
      table.columns = cells.size();
      continue;
    }
    if (words.front() == '#') {
      if (!sure) remarks.push_back(words);
      continue;
    }
    split(words, cells);
    if (!sure) {
      sure = true;
      if (find_header(table, remarks, cells)) continue;
    }
    if (allow_cut && is_cut(cells, table.columns, rest)) {
      table.cut_line = line.number;
      break;
    }
    if (cells.size() != table.columns) {
      const bool more = cells.size() > table.columns;
      refuse(file, line.number, line.column(more ? cells[table.columns].data() : words.data() + words.size()),
             "expected " + std::to_string(table.columns) + " columns as in the header, found " +
                 std::to_string(cells.size()) + (more ? " (is the decimal sign a comma? expected '.')" : ""));
    }
    for (const std::string_view cell : cells) table.values.push_back(parse(file, line, cell, allow_missing));
    table.line.push_back(line.number);
  }
  if (table.header.empty()) refuse(file, 1, 1, "the file is empty; expected a header line and rows of numbers");
  return table;
}

}  // namespace gripline
