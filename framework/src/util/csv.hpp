// Tables of numbers in CSV files, read strictly.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace gripline {

/// Row-major numbers under named columns. `line[i]` is where row i stands in the file, from 1.
struct CsvTable {
  std::filesystem::path file;
  std::vector<std::string> header;
  std::vector<double> values;
  std::vector<int> line;
  std::size_t columns = 0;
  int cut_line = 0;  // of a last row that ends early and was left out; 0: none

  std::size_t rows() const { return line.size(); }
  double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
  /// Index of a column, or -1.
  int find(std::string_view name) const;
  /// One column; throws InputError naming the columns that exist when there is none of that name.
  std::vector<double> column(std::string_view name) const;
};

/// Reads a comma-separated file: one header line (a leading '#' is allowed, and so are remarks behind '#' before it
/// where they have another number of cells), then numbers. CRLF, a trailing newline and a UTF-8 byte order mark are
/// fine. Empty cells and "nan" are refused unless `allow_missing`, which reads them as NaN. A last row with too few
/// cells, or that ends with a sign or an exponent's letter, is refused unless `allow_cut`: as that of a logger that was
/// switched off it is left out. One that ends within the digits of its last number cannot be told from a whole one.
/// Throws InputError with file, line and column: wrong separators, decimal commas, text, rows of another length.
CsvTable read_csv(const std::filesystem::path& file, bool allow_missing = false, bool allow_cut = false);

}  // namespace gripline
