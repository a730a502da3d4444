#include "csv_writer.hpp"

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
  std::filesystem::path aside = file;
  aside += ".partial";
  {
    struct Close {
      void operator()(std::FILE* open) const { std::fclose(open); }
    };
    const std::unique_ptr<std::FILE, Close> out(std::fopen(aside.c_str(), "wb"));
    if (!out || std::fwrite(text.data(), 1, text.size(), out.get()) != text.size() || std::fflush(out.get()) != 0)
      fail(file);
  }
  std::error_code failed;
  std::filesystem::rename(aside, file, failed);
  if (failed) throw std::runtime_error("cannot write " + file.string() + ": " + failed.message());
}

}  // namespace gripline
