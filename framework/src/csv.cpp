#include "csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <span>

#include "config/errors.hpp"
#include "config/files.hpp"

namespace gripline {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, int line, std::size_t column, std::string message) {
  throw InputError({Diagnostic{file.string(), line, static_cast<int>(column) + 1, "", std::move(message), {}}});
}

std::string_view trim(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

/// Cells of one line with the column at which each begins.
struct Cell {
  std::string_view text;
  std::size_t begin;
};
void split(std::string_view line, std::vector<Cell>& cells) {
  cells.clear();
  std::size_t begin = 0;
  while (true) {
    const std::size_t comma = line.find(',', begin);
    const std::size_t end = comma == std::string_view::npos ? line.size() : comma;
    cells.push_back({trim(line.substr(begin, end - begin)), begin});
    if (comma == std::string_view::npos) return;
    begin = comma + 1;
  }
}

double parse(const std::filesystem::path& file, int line, const Cell& cell, bool allow_missing) {
  const bool missing = cell.text.empty() || cell.text == "nan" || cell.text == "NaN";
  if (missing && allow_missing) return std::numeric_limits<double>::quiet_NaN();
  double number = 0.0;
  const char* const end = cell.text.data() + cell.text.size();
  const auto [stop, code] = std::from_chars(cell.text.data(), end, number);
  if (code != std::errc() || stop != end || !std::isfinite(number)) {
    const bool semicolon = cell.text.find(';') != std::string_view::npos;
    refuse(file, line, cell.begin,
           semicolon ? "columns are separated by ';' here; expected ',' between columns and '.' as the decimal sign"
                     : "expected a finite number, found \"" + std::string(cell.text) + "\"");
  }
  return number;
}

}  // namespace

int CsvTable::find(std::string_view name) const {
  const auto found = std::find(header.begin(), header.end(), name);
  return found == header.end() ? -1 : static_cast<int>(found - header.begin());
}

std::vector<double> CsvTable::column(std::string_view name) const {
  const int index = find(name);
  if (index < 0) refuse(file, 1, 0, "no column \"" + std::string(name) + "\"" + did_you_mean(name, header));
  std::vector<double> out(rows());
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = at(i, static_cast<std::size_t>(index));
  return out;
}

CsvTable read_csv(const std::filesystem::path& file, bool allow_missing) {
  const std::string text = read_bytes(file);
  CsvTable table;
  table.file = file;
  std::vector<Cell> cells;
  int line_number = 0;
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::size_t newline = rest.find('\n');
    std::string_view line = trim(rest.substr(0, newline));
    rest.remove_prefix(newline == std::string_view::npos ? rest.size() : newline + 1);
    ++line_number;
    if (line.empty()) continue;
    if (table.header.empty()) {
      if (line.front() == '#') line = trim(line.substr(1));
      split(line, cells);
      for (const Cell& cell : cells) table.header.emplace_back(cell.text);
      table.columns = cells.size();
      if (line.find(';') != std::string_view::npos)
        refuse(file, line_number, line.find(';'), "columns are separated by ';' here; expected ','");
      continue;
    }
    if (line.front() == '#') continue;
    split(line, cells);
    if (cells.size() != table.columns)
      refuse(file, line_number, 0,
             "expected " + std::to_string(table.columns) + " columns as in the header, found " +
                 std::to_string(cells.size()) +
                 (cells.size() > table.columns ? " (is the decimal sign a comma? expected '.')" : ""));
    for (const Cell& cell : cells) table.values.push_back(parse(file, line_number, cell, allow_missing));
    table.line.push_back(line_number);
  }
  if (table.header.empty()) refuse(file, 1, 0, "the file is empty; expected a header line and rows of numbers");
  return table;
}

}  // namespace gripline
