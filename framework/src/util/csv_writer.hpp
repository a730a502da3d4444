// Rows of numbers written to a file, whole rows at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "util/whole_file.hpp"

namespace gripline {

/// Numbers are written by std::to_chars: shortest text that reads back, whatever the locale; NaN as an empty cell. A
/// row reaches the file when it ends, so that a crash loses no complete row. Throws std::runtime_error with the
/// system's reason when the disk is full or the file cannot be made.
class CsvWriter {
 public:
  CsvWriter(const std::filesystem::path& file, std::string_view header);
  /// Appends to a string instead of a file; it must outlive the writer. For tables that are written whole.
  CsvWriter(std::string& text, std::string_view header);
  /// The table appears when `file`, which must outlive the writer, is finished by its owner.
  CsvWriter(WholeFile& file, std::string_view header);
  CsvWriter(CsvWriter&& other) noexcept;
  CsvWriter& operator=(CsvWriter&&) = delete;
  ~CsvWriter();
  CsvWriter& operator<<(double number);
  CsvWriter& operator<<(int number) { return *this << static_cast<std::int64_t>(number); }
  CsvWriter& operator<<(std::int64_t number);
  CsvWriter& operator<<(std::string_view text);
  void end_row();
  /// Returns when the file is on the disk; nothing can be written afterwards.
  void finish();

 private:
  void separate();
  void write_out();
  std::filesystem::path name_;
  int handle_ = -1;
  std::string* text_ = nullptr;
  WholeFile* whole_ = nullptr;
  std::string row_;
  bool fresh_ = true;
};

}  // namespace gripline
