#include "measured/session/channel_reader.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "config/errors.hpp"
#include "config/units.hpp"
#include "tables/refuse_file.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {
namespace {

/// What is wrong with a column of the table, in words for its file.
struct UnreadColumn {
  std::string message;
  int line;
};

}  // namespace

void ChannelReader::note(std::string check, std::string found, std::string done) {
  findings_.push_back({Finding::Level::note, std::move(check), std::move(found), std::move(done)});
}

/// What one of the channel's numbers is in SI: by the map's unit, else by the unit in the table's header.
ChannelReader::Factor ChannelReader::factor_of(const MappedChannel& channel, const char* unit, const Formula& formula) {
  if (!channel.unit.empty()) return {to_si("1 " + channel.unit, unit)};
  if (formula.columns().size() != 1) return {};
  const std::string& name = table_.name[formula.columns()[0]];
  const bool bare = channel.formula == name || channel.formula == '`' + name + '`';
  if (!bare && !channel.formula.starts_with('`')) return {};
  const std::string& written = table_.unit[formula.columns()[0]];
  if (written.empty()) return {};
  // Arithmetic may convert already what only a reader of headers understands.
  const std::string known = header_unit(written, unit, bare);
  if (!known.empty()) return {to_si("1 " + known, unit), true};
  if (!bare) return {};
  note("unit", name + ": the header's \"" + written + "\" is not a unit of this kind",
       std::string("taken for ") + unit + "; `unit` in the map says another");
  return {};
}

/// Says once of a column that text stands where numbers are expected; a column of nothing else is refused.
void ChannelReader::check_cells(std::size_t column, bool of_time) {
  if (column >= table_.unread.size() || table_.unread[column].cells == 0) return;
  const DelimitedTable::Unread& unread = table_.unread[column];
  const bool none = std::ranges::all_of(table_.column[column], [](double v) { return std::isnan(v); });
  const std::string forms =
      of_time ? "; times are read as 12.5, 1:02.5, 12:34:56.7 and 2018-04-08 10:31:37.5" : std::string();
  const std::string first = "\"" + unread.first + "\"";
  if (none)
    throw UnreadColumn{"column " + table_.name[column] + ": none of its cells is a number; the first is " + first +
                           (of_time ? forms : "; expected numbers alone, as 12.5 or -2e-3"),
                       unread.line};
  if (!reported_.insert(column).second) return;
  note("cells",
       table_.name[column] + ": " + std::to_string(unread.cells) + " are not numbers, the first " + first +
           " in line " + std::to_string(unread.line) + forms,
       "taken for missing");
}

/// Which of two columns of one name is meant, nobody can tell.
void ChannelReader::check_name(std::size_t column) const {
  const std::string& name = table_.name[column];
  if (std::ranges::find(table_.repeated, name) == table_.repeated.end()) return;
  throw UnreadColumn{"column " + name + " stands more than once in the header; expected each column that is read once",
                     0};
}

ChannelValues ChannelReader::read(const MappedChannel& channel, const char* unit, const char* name,
                                  const std::vector<double>& time) {
  try {
    const Formula formula(channel.formula, table_, std::string(name));
    for (const std::size_t column : formula.columns()) {
      check_name(column);
      check_cells(column, name == std::string_view("time"));
    }
    ChannelValues read{formula.evaluate(table_, time)};
    const Factor in_si = factor_of(channel, unit, formula);
    read.unit_of_header = in_si.of_header;
    const double factor = channel.sign * in_si.value;
    for (double& v : read.value) v = std::isfinite(v) ? factor * v : not_a_number;
    return read;
  } catch (const UnreadColumn& problem) {
    refuse_file(table_.file, problem.message, problem.line);
  } catch (const InputError& problem) {
    if (map_.file.empty()) refuse_file(table_.file, problem.what(), 1);
    Diagnostic d;
    d.file = map_.file.string();
    d.line = channel.origin.line;
    d.column = channel.origin.column;
    d.pointer = channel.origin.pointer;
    d.message = std::string(problem.what()) + " in " + table_.file.string();
    throw InputError({d});
  }
}

}  // namespace gripline::measured
