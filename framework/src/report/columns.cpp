#include "report/columns.hpp"

#include <charconv>
#include <cstdint>
#include <fstream>
#include <limits>

#include <utility>

#include "config/errors.hpp"
#include "util/numbers.hpp"

namespace gripline::report {
namespace {

/// Takes the next cell off `line`. `scratch` holds it when quotes had to be undone.
std::string_view take_cell(std::string_view& line, std::string& scratch, bool& last) {
  if (line.empty() || line.front() != '"') {
    const std::size_t comma = line.find(',');
    const std::string_view cell = line.substr(0, comma);
    last = comma == line.npos;
    line.remove_prefix(last ? line.size() : comma + 1);
    return cell;
  }
  scratch.clear();
  std::size_t i = 1;
  for (; i < line.size(); ++i) {
    if (line[i] != '"') {
      scratch += line[i];
    } else if (i + 1 < line.size() && line[i + 1] == '"') {
      scratch += line[i++];
    } else {
      break;
    }
  }
  const std::size_t comma = line.find(',', i);
  last = comma == line.npos;
  line.remove_prefix(last ? line.size() : comma + 1);
  return scratch;
}

/// One record: up to a line end outside quotes. Empty view and `text` untouched if the record is not complete.
bool take_record(std::string_view& text, std::string_view& record) {
  std::size_t end = text.find('\n');
  const bool quotes = end != text.npos && text.substr(0, end).find('"') != text.npos;
  if (quotes) {
    bool inside = false;
    for (end = 0; end < text.size() && (inside || text[end] != '\n'); ++end) inside ^= text[end] == '"';
  }
  if (end == text.npos || end >= text.size()) return false;
  record = text.substr(0, end);
  if (!record.empty() && record.back() == '\r') record.remove_suffix(1);
  text.remove_prefix(end + 1);
  return true;
}

double to_number(std::string_view cell) {
  double number = not_a_number;
  const auto [stop, code] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
  return code == std::errc() && stop == cell.data() + cell.size() ? number : not_a_number;
}

}  // namespace

Columns Columns::parse(std::string_view text, bool with_texts) {
  Columns table;
  std::string scratch;
  std::string_view record;
  if (!take_record(text, record)) return table;
  std::vector<Column*> order;
  for (bool last = false; !last;) {
    const std::string name(take_cell(record, scratch, last));
    table.names_.push_back(name);
    order.push_back(&table.columns_[name]);
  }
  while (take_record(text, record)) {
    if (record.empty()) continue;
    bool last = false;
    for (Column* column : order) {
      const std::string_view cell = last ? std::string_view() : take_cell(record, scratch, last);
      if (column->numbers.size() > table.rows_) continue;  // a name that stands twice: the first one counts
      column->numbers.push_back(to_number(cell));
      if (with_texts) column->texts.emplace_back(cell);
    }
    ++table.rows_;
  }
  return table;
}

Columns Columns::read(const std::filesystem::path& file, bool with_texts) {
  return parse(read_whole_file(file), with_texts);
}

std::span<const double> Columns::numbers(std::string_view name) const {
  const auto found = columns_.find(name);
  return found == columns_.end() ? std::span<const double>() : std::span<const double>(found->second.numbers);
}

double Columns::number(std::string_view name, std::size_t row) const {
  const std::span<const double> column = numbers(name);
  return row < column.size() ? column[row] : not_a_number;
}

std::string Columns::text(std::string_view name, std::size_t row) const {
  const auto found = columns_.find(name);
  return found == columns_.end() || row >= found->second.texts.size() ? std::string() : found->second.texts[row];
}

std::string read_whole_file(const std::filesystem::path& file) {
  constexpr std::uintmax_t most_bytes = std::uintmax_t{1} << 30U;
  std::error_code failed;
  const std::filesystem::file_status status = std::filesystem::status(file, failed);
  if (status.type() == std::filesystem::file_type::not_found) return {};
  // Opening a pipe would block until another process writes to it.
  if (!std::filesystem::is_regular_file(status))
    throw InputError(file.string() + ": cannot be read: not a regular file");
  if (std::filesystem::file_size(file, failed) > most_bytes)
    throw InputError(file.string() + ": is larger than 1 GB; no run of ours writes that");
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) throw InputError(file.string() + ": cannot be read");
  std::string text(static_cast<std::size_t>(in.tellg()), '\0');
  in.seekg(0);
  if (!in.read(text.data(), static_cast<std::streamsize>(text.size())) && !text.empty())
    throw InputError(file.string() + ": cannot be read");
  return text;
}

}  // namespace gripline::report
