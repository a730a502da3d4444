#include "util/csv_writer.hpp"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "util/disk.hpp"

namespace gripline {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file) { fail_with_errno("cannot write " + file.string()); }

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

CsvWriter::CsvWriter(WholeFile& file, std::string_view header) : whole_(&file) {
  row_ = header;
  end_row();
}

CsvWriter::CsvWriter(CsvWriter&& other) noexcept
    : name_(std::move(other.name_)),
      handle_(std::exchange(other.handle_, -1)),
      text_(other.text_),
      whole_(other.whole_),
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
  else if (whole_ != nullptr)
    whole_->write(row_);
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

}  // namespace gripline
