// Rows of numbers written to a file, whole rows at a time.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace gripline {

/// Numbers are written by std::to_chars: shortest text that reads back, whatever the locale; NaN as an empty cell. A
/// row reaches the file when it ends, so that a crash loses no complete row. Throws std::runtime_error with the
/// system's reason when the disk is full or the file cannot be made.
class CsvWriter {
 public:
  CsvWriter(const std::filesystem::path& file, std::string_view header);
  CsvWriter& operator<<(double number);
  CsvWriter& operator<<(int number) { return *this << static_cast<std::int64_t>(number); }
  CsvWriter& operator<<(std::int64_t number);
  CsvWriter& operator<<(std::string_view text);
  void end_row();

 private:
  void separate();
  void write_out();
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::filesystem::path name_;
  std::unique_ptr<std::FILE, Close> file_;
  std::string row_;
  bool fresh_ = true;
};

/// Writes a file aside and renames it, so that it is either whole or absent. Symbolic links are followed to what they
/// name; what is no regular file (a device, a pipe) is written to as it is. Throws std::runtime_error.
void write_file(const std::filesystem::path& file, std::string_view text);

}  // namespace gripline
