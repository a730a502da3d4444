#include "tables/delimited_table.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "config/files.hpp"
#include "config/units.hpp"
#include "tables/cell_value.hpp"
#include "tables/refuse_file.hpp"
#include "tables/text_encoding.hpp"

namespace gripline {
namespace {

struct Line {
  std::string_view text;
  int number = 0;
};

bool is_comment(std::string_view text) {
  text = trim_cell(text);
  return text.starts_with('#') || text.starts_with("//") || text.starts_with('%');
}

std::string_view without_comment_sign(std::string_view text) {
  text = trim_cell(text);
  while (text.starts_with('#') || text.starts_with('%') || text.starts_with('/')) text.remove_prefix(1);
  return trim_cell(text);
}

std::vector<Line> lines_of(std::string_view text) {
  std::vector<Line> lines;
  int number = 0;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++number;
    const std::string_view words = trim_cell(line);
    if (words.empty()) continue;
    // Tabs before the words separate empty cells; those behind them would be cells that every row may lack.
    line = line.substr(0, static_cast<std::size_t>(words.data() - line.data()) + words.size());
    lines.push_back({line, number});
  }
  return lines;
}

/// Cells of a line; a quoted cell may hold the separator. Blanks as separator count once however many there are.
std::vector<std::string_view> split(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  std::size_t begin = 0;
  while (begin <= line.size()) {
    if (separator == ' ')
      while (begin < line.size() && (line[begin] == ' ' || line[begin] == '\t')) ++begin;
    std::size_t end = begin;
    bool quoted = false;
    while (end < line.size() && (quoted || (line[end] != separator && !(separator == ' ' && line[end] == '\t')))) {
      if (line[end] == '"') quoted = !quoted;
      ++end;
    }
    std::string_view cell = trim_cell(line.substr(begin, end - begin));
    if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"')
      cell = trim_cell(cell.substr(1, cell.size() - 2));
    cells.push_back(cell);
    begin = end + 1;
    if (end >= line.size()) break;
  }
  if (separator == ' ' && !cells.empty() && cells.back().empty()) cells.pop_back();
  return cells;
}

bool is_word(std::string_view cell) {
  return std::any_of(cell.begin(), cell.end(), [](unsigned char c) { return std::isalpha(c) != 0 || c >= 0x80; });
}

struct Shape {
  char separator = ',';
  bool decimal_comma = false;
  std::size_t cells = 0;  // of most lines
  std::size_t rows = 0;   // lines of that length that hold numbers
};

/// Lines in the later part of the file, where no preamble is left.
std::vector<Line> sample_of(const std::vector<Line>& lines) {
  std::vector<Line> sample;
  const std::size_t first = lines.size() > 40 ? lines.size() / 3 : lines.size() > 4 ? lines.size() / 2 : 0;
  const std::size_t step = std::max<std::size_t>(1, (lines.size() - first) / 200);
  for (std::size_t i = first; i < lines.size(); i += step)
    if (!is_comment(lines[i].text)) sample.push_back(lines[i]);
  return sample;
}

/// "1,234" is another number where the comma groups digits.
bool may_group_thousands(std::string_view cell) {
  const std::size_t comma = cell.find(',');
  return comma != std::string_view::npos && comma > 0 && cell.size() == comma + 4 && !cell.starts_with('0') &&
         !cell.starts_with("-0");
}

Shape shape_with(const std::vector<Line>& sample, char separator) {
  std::map<std::size_t, std::size_t> lengths;
  for (const Line& line : sample) ++lengths[split(line.text, separator).size()];
  Shape shape;
  shape.separator = separator;
  std::size_t most = 0;
  for (const auto& [length, count] : lengths)
    if (count >= most) most = count, shape.cells = length;
  std::size_t points = 0, commas = 0;
  for (const Line& line : sample) {
    const auto cells = split(line.text, separator);
    if (cells.size() != shape.cells) continue;
    std::size_t good = 0;
    for (const std::string_view cell : cells) {
      const bool comma = cell.find(',') != std::string_view::npos && !(separator == ',' && may_group_thousands(cell));
      const bool number = !std::isnan(read_cell(cell, comma));
      good += number || is_missing(cell);
      points += number && cell.find('.') != std::string_view::npos;
      commas += number && comma;
    }
    shape.rows += 2 * good > cells.size();
  }
  shape.decimal_comma = commas > points;
  return shape;
}

Shape shape_of(const std::vector<Line>& sample) {
  Shape best;
  for (const char separator : {'\t', ';', ',', '|', ' '}) {
    const Shape shape = shape_with(sample, separator);
    if (shape.cells < 2) continue;
    // A row more is worth more than a column more: decimal commas make longer, ragged lines of a table of semicolons.
    const bool better = shape.rows * 10 > best.rows * 11 ||
                        (shape.rows * 11 >= best.rows * 10 && shape.cells > best.cells && best.separator != ';');
    if (best.cells < 2 || better) best = shape;
  }
  return best;
}

/// "Speed (km/h)" and "Speed [km/h]" are a name and a unit.
void split_unit_off(std::string& name, std::string& unit) {
  for (const auto& [open, close] : {std::pair('[', ']'), {'(', ')'}}) {
    const std::size_t begin = name.rfind(open);
    if (begin == std::string::npos || begin == 0 || name.back() != close) continue;
    const std::string_view inside = std::string_view(name).substr(begin + 1, name.size() - begin - 2);
    const bool number = !inside.empty() && inside.find_first_not_of("0123456789") == std::string_view::npos;
    // An element of a topic's array, "/wheels.speed[3]"; "Throttle [1]" has the unit one.
    if (open == '[' && number && name.front() == '/' && name[begin - 1] != ' ') continue;
    unit = name.substr(begin + 1, name.size() - begin - 2);
    name = std::string(trim_cell(std::string_view(name).substr(0, begin)));
    return;
  }
}

/// Whether a cell of a header is a unit of a channel.
bool is_unit(std::string_view cell) {
  constexpr const char* kinds[] = {"s", "m", "m/s", "m/s2", "rad", "rad/s", "N", "1"};
  return std::ranges::any_of(kinds, [&](const char* kind) { return !header_unit(cell, kind).empty(); });
}

/// Returns the names that stood there more than once.
std::vector<std::string> make_unique(std::vector<std::string>& names) {
  std::set<std::string> seen;
  std::vector<std::string> repeated;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i].empty()) names[i] = "column_" + std::to_string(i + 1);
    std::string name = names[i];
    for (int n = 2; !seen.insert(name).second; ++n) name = names[i] + "_" + std::to_string(n);
    if (name != names[i]) repeated.push_back(names[i]);
    names[i] = name;
  }
  return repeated;
}

/// Whether a line of the table's length is a row of numbers.
bool is_row(const std::vector<std::string_view>& cells, bool decimal_comma) {
  std::size_t numbers = 0, words = 0;
  for (const std::string_view cell : cells) {
    if (!std::isnan(read_cell(cell, decimal_comma)))
      ++numbers;
    else
      words += is_word(cell) && !is_missing(cell);
  }
  return numbers > words;
}

struct Reader {
  DelimitedTable table;
  std::vector<Line> lines;
  Shape shape;
  std::size_t first = 0;  // line of the first row

  std::vector<std::string_view> cells(const Line& line) const {
    auto all = split(line.text, shape.separator);
    if (all.size() == shape.cells + 1 && all.back().empty()) all.pop_back();
    return all;
  }

  /// Whether a row may lack empty cells at its end. The last line of a file that was cut off ends anywhere, and blanks
  /// do not tell which cell is empty.
  bool lacks_cells(const std::vector<std::string_view>& row, std::size_t at) const {
    return shape.separator != ' ' && at + 1 < lines.size() && row.size() > 1 && row.size() < shape.cells &&
           2 * row.size() > shape.cells;
  }

  /// Where most rows lack cells, the header tells how many there are.
  void widen_to_header() {
    if (first == 0 || shape.separator == ' ' || is_comment(lines[first - 1].text)) return;
    const auto header = split(lines[first - 1].text, shape.separator);
    const bool names = std::ranges::all_of(header, [](std::string_view cell) { return is_word(cell); });
    if (!names || header.size() <= shape.cells || header.size() >= 2 * shape.cells) return;
    const bool filled =
        std::any_of(lines.begin() + static_cast<std::ptrdiff_t>(first), lines.end(),
                    [&](const Line& l) { return split(l.text, shape.separator).size() == header.size(); });
    if (filled) shape.cells = header.size();
  }

  bool is_short_row(std::size_t at) const {
    const auto row = cells(lines[at]);
    return !is_comment(lines[at].text) && lacks_cells(row, at) && is_row(row, shape.decimal_comma);
  }

  void find_first_row() {
    for (first = 0; first < lines.size(); ++first) {
      if (is_comment(lines[first].text)) continue;
      const auto row = cells(lines[first]);
      if (row.size() != shape.cells || !is_row(row, shape.decimal_comma)) continue;
      while (first > 0 && is_short_row(first - 1)) --first;
      widen_to_header();
      return;
    }
    refuse_file(table.file, "no row of numbers; expected a header line and rows of numbers");
  }

  struct Above {
    std::vector<std::string_view> cells;
    int line = 0;
    bool comment = false;
    std::size_t filled() const {
      return cells.size() - static_cast<std::size_t>(std::count(cells.begin(), cells.end(), std::string_view()));
    }
  };

  /// Lines of words right above the first row, nearest last: the header, perhaps units, perhaps more.
  std::vector<Above> lines_above() const {
    std::vector<Above> above;
    for (std::size_t i = first; i-- > 0;) {
      const bool comment = is_comment(lines[i].text);
      const bool below_comment = !above.empty() && above.back().comment;
      if (comment && below_comment) continue;
      auto row = split(comment ? without_comment_sign(lines[i].text) : lines[i].text, shape.separator);
      if (row.size() == shape.cells + 1 && row.back().empty()) row.pop_back();
      // Trailing empty cells may be left out above the rows.
      if (!comment && row.size() < shape.cells && 2 * row.size() > shape.cells && row.size() > 1)
        row.resize(shape.cells);
      if (row.size() != shape.cells) {
        if (comment && above.empty()) continue;
        break;
      }
      const bool nearest = above.empty();
      above.insert(above.begin(), {row, lines[i].number, comment});
      if (comment && !nearest) break;  // one right above the rows may hold the units of a header without a sign
    }
    return above;
  }

  /// Whether most of what a row says are units, and not names.
  static bool is_row_of_units(const Above& row) {
    const auto units = std::ranges::count_if(row.cells, [](std::string_view cell) { return is_unit(cell); });
    return 2 * static_cast<std::size_t>(units) > row.filled();
  }

  void read_header(std::string_view example) {
    const auto above = lines_above();
    if (above.empty())
      refuse_file(table.file,
                  "no header line of " + std::to_string(shape.cells) +
                      " names above the first row of numbers; expected the names of the columns" +
                      (example.empty() ? "" : ", as " + std::string(example)),
                  lines[first].number);
    // Lines of a preamble may be as long, but name fewer things; a row of units stands below the header. A comment
    // right above the rows holds units where most of it are some, else it is the header.
    const bool comment = above.back().comment, units = comment && above.size() > 1 && is_row_of_units(above.back());
    const auto header = comment && !units
                            ? above.end() - 1
                            : std::max_element(above.begin(), above.end() - (units ? 1 : 0),
                                               [](const Above& a, const Above& b) { return a.filled() < b.filled(); });
    const int at = table.header_line = header->line;
    for (const std::string_view cell : header->cells) table.name.emplace_back(cell);
    table.unit.resize(shape.cells);
    for (std::size_t c = 0; c < shape.cells; ++c) split_unit_off(table.name[c], table.unit[c]);
    if (header + 1 != above.end()) {
      table.unit_row = true;
      table.found.push_back("units in a row of their own");
      for (std::size_t c = 0; c < shape.cells; ++c)
        if (table.unit[c].empty()) table.unit[c] = std::string(header[1].cells[c]);
    }
    std::size_t before = 0;
    for (const Line& line : lines) before += line.number < at && !is_comment(line.text);
    if (before > 0) table.found.push_back(std::to_string(before) + " lines before the header");
    table.repeated = make_unique(table.name);
  }

  void count_unread(std::size_t column, std::string_view cell, int line) {
    DelimitedTable::Unread& unread = table.unread[column];
    if (unread.cells++ > 0) return;
    unread.first = cell.substr(0, 40);
    unread.line = line;
  }

  void read_rows() {
    table.column.resize(shape.cells);
    table.unread.resize(shape.cells);
    std::size_t ragged = 0, padded = 0;
    for (std::size_t i = first; i < lines.size(); ++i) {
      if (is_comment(lines[i].text)) continue;
      auto row = cells(lines[i]);
      if (lacks_cells(row, i)) {
        row.resize(shape.cells);
        ++padded;
      }
      if (row.size() != shape.cells) {
        if (ragged++ == 0) table.other_length = lines[i].number;
        continue;
      }
      for (std::size_t c = 0; c < shape.cells; ++c) {
        table.column[c].push_back(read_cell(row[c], shape.decimal_comma));
        if (std::isnan(table.column[c].back()) && !is_missing(row[c])) count_unread(c, row[c], lines[i].number);
      }
      if (i == first)
        for (const std::string_view cell : row) table.of_clock.push_back(cell.find(':') != std::string_view::npos);
      table.line.push_back(lines[i].number);
    }
    if (padded > 0) table.found.push_back(std::to_string(padded) + " rows lack cells at their end, taken for empty");
    if (ragged > 0) table.found.push_back(std::to_string(ragged) + " rows of another length, left out");
  }
};

}  // namespace

int DelimitedTable::find(std::string_view wanted) const {
  const auto found_at = std::find(name.begin(), name.end(), wanted);
  return found_at == name.end() ? -1 : static_cast<int>(found_at - name.begin());
}

DelimitedTable read_delimited(const std::filesystem::path& file, std::string_view example) {
  std::string text = read_bytes(file);
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
  std::string_view rest = text;
  if (rest.starts_with("\xff\xfe") || rest.starts_with("\xfe\xff"))
    refuse_file(file, "the file is UTF-16; expected UTF-8 (save it again as UTF-8 or ASCII)");
  if (rest.starts_with("#ROSBAG V") || rest.starts_with("SQLite format 3"))
    refuse_file(file,
                "the file is a bag of ROS; expected a table in text (gripline import BAG --map MAP --table FILE.csv "
                "writes what the map reads of it)");
  if (rest.find('\0') != std::string_view::npos)
    refuse_file(file, "the file is not a text; expected a table in text, as CSV");
  const bool windows = to_utf8(text);
  Reader reader;
  reader.table.file = file;
  reader.lines = lines_of(text);
  if (reader.lines.empty()) refuse_file(file, "the file is empty; expected a header line and rows of numbers");
  reader.shape = shape_of(sample_of(reader.lines));
  if (reader.shape.cells < 2)
    refuse_file(file, "no separator makes columns of this; expected comma, semicolon, tab, '|' or blanks between cells",
                reader.lines.front().number);
  reader.find_first_row();
  reader.read_header(example);
  reader.read_rows();
  const std::map<char, const char*> names = {
      {';', "semicolons"}, {'\t', "tabs"}, {'|', "vertical bars"}, {' ', "blanks"}};
  if (reader.shape.separator != ',')
    reader.table.found.push_back(std::string("columns separated by ") + names.at(reader.shape.separator));
  if (reader.shape.decimal_comma) reader.table.found.push_back("decimal commas");
  if (windows) reader.table.found.push_back("letters that are not UTF-8, taken for Windows-1252");
  return std::move(reader.table);
}

}  // namespace gripline
