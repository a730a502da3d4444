#include "util/csv_writer.hpp"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "util/disk.hpp"

namespace gripline {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file) {
  throw std::runtime_error("cannot write " + file.string() + ": " + std::strerror(errno));
}

/// Closes a handle at the end of a block.
class Handle {
 public:
  explicit Handle(int handle) : handle_(handle) {}
  ~Handle() {
    if (handle_ >= 0) disk().close(handle_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  bool good() const { return handle_ >= 0; }
  bool write(std::string_view text) const { return disk().write(handle_, text); }
  bool sync() const { return disk().sync(handle_); }

 private:
  int handle_;
};

/// The file that a chain of symbolic links names, whether it exists or not.
std::filesystem::path link_target(std::filesystem::path file) {
  constexpr int most_links = 40;  // the limit of Linux
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
    : name_(file), handle_(disk().create(file)) {
  if (handle_ < 0) fail(name_);
  row_ = header;
  try {
    end_row();
  } catch (const std::runtime_error&) {
    disk().close(handle_);
    throw;
  }
}

CsvWriter::CsvWriter(std::string& text, std::string_view header) : text_(&text) {
  row_ = header;
  end_row();
}

CsvWriter::CsvWriter(CsvWriter&& other) noexcept
    : name_(std::move(other.name_)),
      handle_(std::exchange(other.handle_, -1)),
      text_(other.text_),
      row_(std::move(other.row_)),
      fresh_(other.fresh_) {}

CsvWriter::~CsvWriter() {
  if (handle_ >= 0) disk().close(handle_);
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
  if (text_ != nullptr)
    *text_ += row_;
  else if (!disk().write(handle_, row_))
    fail(name_);
}

void CsvWriter::finish() {
  if (handle_ < 0) return;
  const int handle = std::exchange(handle_, -1);
  const bool safe = disk().sync(handle);
  const int why = errno;
  disk().close(handle);
  errno = why;
  if (!safe) fail(name_);
}

void write_file(const std::filesystem::path& file, std::string_view text) {
  const std::filesystem::path place = link_target(file);
  std::error_code failed;
  const std::filesystem::file_status status = std::filesystem::status(place, failed);
  // A device, a pipe or a socket is written to directly: renaming a temporary file would replace it.
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    const Handle out(disk().create(place));
    if (!out.good() || !out.write(text)) fail(file);
    return;
  }
  std::filesystem::path aside = place;
  aside += ".partial";
  bool written = false;
  {
    const Handle out(disk().create_anew(aside));
    written = out.good() && out.write(text) && out.sync();
  }
  written = written && disk().rename(aside, place);
  if (!written) {
    const int why = errno;
    std::filesystem::remove(aside, failed);
    errno = why;
    fail(file);
  }
  if (!disk().sync_folder(place.parent_path())) fail(file);
}

}  // namespace gripline
