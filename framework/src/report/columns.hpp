// A CSV file by columns. Lenient, for files that gripline wrote itself.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gripline::report {

/// Numbers by column; a cell that is not a number is NaN. Quoted cells (RFC 4180) are understood. A last line without
/// its line end is dropped: the program was stopped while writing it. Missing cells at the end of a row are empty.
class Columns {
 public:
  /// `with_texts` keeps every cell as written too; for small tables.
  static Columns parse(std::string_view text, bool with_texts = false);
  /// An absent file gives no columns. Throws InputError if it is there and cannot be read.
  static Columns read(const std::filesystem::path& file, bool with_texts = false);

  [[nodiscard]] std::size_t rows() const { return rows_; }
  [[nodiscard]] bool empty() const { return rows_ == 0; }
  [[nodiscard]] bool has(std::string_view name) const { return columns_.find(name) != columns_.end(); }
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  /// Empty if there is no such column.
  [[nodiscard]] std::span<const double> numbers(std::string_view name) const;
  /// NaN if there is no such column.
  [[nodiscard]] double number(std::string_view name, std::size_t row) const;
  /// The cell as written; empty without such a column, or if the texts were not kept.
  [[nodiscard]] std::string text(std::string_view name, std::size_t row) const;

 private:
  struct Column {
    std::vector<double> numbers;
    std::vector<std::string> texts;
  };
  std::vector<std::string> names_;
  std::map<std::string, Column, std::less<>> columns_;
  std::size_t rows_ = 0;
};

/// The whole file; empty if there is none. Throws InputError naming the file if it cannot be read.
std::string read_whole_file(const std::filesystem::path& file);

}  // namespace gripline::report
