#include "util/csv_writer.hpp"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace gripline {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file) {
  throw std::runtime_error("cannot write " + file.string() + ": " + std::strerror(errno));
}

struct CloseFile {
  void operator()(std::FILE* open) const { std::fclose(open); }
};

void write_to(const std::filesystem::path& place, std::string_view text, const std::filesystem::path& shown) {
  const std::unique_ptr<std::FILE, CloseFile> out(std::fopen(place.c_str(), "wb"));
  if (!out || std::fwrite(text.data(), 1, text.size(), out.get()) != text.size() || std::fflush(out.get()) != 0)
    fail(shown);
}

/// Where a chain of symbolic links leads, also when nothing is there yet.
std::filesystem::path behind_links(std::filesystem::path file) {
  constexpr int most_links = 40;  // as Linux follows
  std::error_code failed;
  for (int i = 0; i < most_links && std::filesystem::is_symlink(file, failed); ++i) {
    const std::filesystem::path next = std::filesystem::read_symlink(file, failed);
    if (failed) break;
    file = next.is_absolute() ? next : file.parent_path() / next;
  }
  return file;
}

}  // namespace

CsvWriter::CsvWriter(const std::filesystem::path& file, std::string_view header)
    : name_(file), file_(std::fopen(file.c_str(), "wb")) {
  if (!file_) fail(name_);
  std::setvbuf(file_.get(), nullptr, _IONBF, 0);
  row_ = header;
  end_row();
}

void CsvWriter::separate() {
  if (!fresh_) row_ += ',';
  fresh_ = false;
}

CsvWriter& CsvWriter::operator<<(double number) {
  separate();
  if (std::isnan(number)) return *this;
  char text[32];
  const auto result = std::to_chars(text, text + sizeof text, number);
  row_.append(text, result.ptr);
  return *this;
}

CsvWriter& CsvWriter::operator<<(std::int64_t number) {
  separate();
  row_ += std::to_string(number);
  return *this;
}

CsvWriter& CsvWriter::operator<<(std::string_view text) {
  separate();
  row_ += text;
  return *this;
}

void CsvWriter::end_row() {
  row_ += '\n';
  write_out();
  row_.clear();
  fresh_ = true;
}

void CsvWriter::write_out() {
  if (std::fwrite(row_.data(), 1, row_.size(), file_.get()) != row_.size()) fail(name_);
}

void write_file(const std::filesystem::path& file, std::string_view text) {
  const std::filesystem::path place = behind_links(file);
  std::error_code failed;
  const std::filesystem::file_status status = std::filesystem::status(place, failed);
  // A device, a pipe or a socket is written to; a file made aside would take its place.
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) return write_to(place, text, file);
  std::filesystem::path aside = place;
  aside += ".partial";
  try {
    write_to(aside, text, file);
  } catch (const std::runtime_error&) {
    std::filesystem::remove(aside, failed);
    throw;
  }
  std::filesystem::rename(aside, place, failed);
  if (failed) throw std::runtime_error("cannot write " + file.string() + ": " + failed.message());
}

}  // namespace gripline
