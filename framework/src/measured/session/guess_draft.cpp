#include "measured/session/guess_draft.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <string_view>

#include "config/units.hpp"
#include "measured/readings/held_readings.hpp"
#include "measured/session/log_map.hpp"
#include "tables/column_names.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

/// Whether a formula has this name, not as a part of another one.
bool has_name(std::string_view formula, std::string_view name) {
  const auto part = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '.' || c >= 0x80; };
  for (std::size_t at = 0; (at = formula.find(name, at)) != std::string_view::npos; ++at) {
    const std::size_t end = at + name.size();
    const bool begins = at == 0 || !part(static_cast<unsigned char>(formula[at - 1]));
    if (begins && (end == formula.size() || !part(static_cast<unsigned char>(formula[end])))) return true;
  }
  return false;
}

}  // namespace

int GuessDraft::column(const char* channel) const {
  const int named = column_by_name(channel);
  const auto is_course = [&](int c) { return is_called_course(known_as(static_cast<std::size_t>(c))); };
  if (named >= 0 && !is_course(named)) return named;
  // A course only where nothing is called a heading.
  const int by_path = column_by_path(channel);
  return named >= 0 && (by_path < 0 || is_course(by_path)) ? named : by_path;
}

int GuessDraft::column_by_name(const char* channel) const {
  const char* const kind = unit_kind(channel);
  const std::string_view of = channel;
  for (const std::string_view word : names_of(channel)) {
    const bool only_both = word == "u" || (word == "v" && of == "vy"), only_alone = word == "v" && of == "vx";
    if ((only_both && !has_u_and_v()) || (only_alone && has_u_and_v())) continue;
    for (std::size_t c = 0; c < table.name.size(); ++c)
      if (is_called(known_as(c), word, kind) && !is_zero(c)) return static_cast<int>(c);
  }
  return -1;
}

int GuessDraft::column_by_path(const char* channel) const {
  const char* const kind = unit_kind(channel);
  const auto look = [&](bool of_command) {
    for (const char* word : names_of(channel))
      for (std::size_t c = 0; c < table.name.size(); ++c)
        if (is_called_in_path(known_as(c), word, kind) && is_path_of_command(known_as(c)) == of_command && !is_zero(c))
          return static_cast<int>(c);
    return -1;
  };
  constexpr std::string_view commands[] = {"d", "throttle", "brake", "delta", "steering_wheel"};
  const bool commanded = std::ranges::find(commands, std::string_view(channel)) != std::end(commands);
  const int of_command = commanded ? look(true) : -1;
  return of_command >= 0 ? of_command : look(false);
}

bool GuessDraft::has_u_and_v() const {
  constexpr double enough = 0.02;  // of the rows: a speed is hardly ever below 0
  const auto find = [&](const char* word) {
    for (std::size_t c = 0; c < table.name.size(); ++c)
      if (is_called(known_as(c), word, "m/s") && (table.unit[c].empty() || !header_unit(table.unit[c], "m/s").empty()))
        return static_cast<int>(c);
    return -1;
  };
  const int u = find("u"), v = find("v");
  if (u < 0 || v < 0 || !(quantile_of_size(values(u), 0.5) > quantile_of_size(values(v), 0.5))) return false;
  const auto below = std::ranges::count_if(values(v), [](double one) { return one < 0.0; });
  return static_cast<double>(below) > enough * static_cast<double>(table.rows());
}

bool GuessDraft::is_zero(std::size_t c) const { return !(quantile_of_size(table.column[c], 1.0) > 0.0); }

const std::string& GuessDraft::known_as(std::size_t c) const {
  return table.meaning.empty() ? table.name[c] : table.meaning[c];
}

std::string GuessDraft::quoted(int c) const {
  const std::string& n = name(c);
  const bool word =
      std::all_of(n.begin(), n.end(), [](unsigned char ch) { return std::isalnum(ch) != 0 || ch == '_'; });
  return word && std::isdigit(static_cast<unsigned char>(n.front())) == 0 ? n : "`" + n + "`";
}

std::string GuessDraft::unit_of_name(int c, const char* wanted) const {
  return unit_at_end(known_as(static_cast<std::size_t>(c)), wanted);
}

std::string GuessDraft::unit_of(int c, const char* wanted) {
  const std::string& written = table.unit[static_cast<std::size_t>(c)];
  if (std::string known = header_unit(written, wanted); !known.empty()) return known;
  if (std::string known = unit_of_name(c, wanted); !known.empty()) return known;
  if (!written.empty())
    remarks.push_back(name(c) + ": the header's \"" + written + "\" is not a unit of this kind; taken for " + wanted);
  return wanted;
}

std::pair<double, double> GuessDraft::range(std::size_t c) const {
  double low = INFINITY, high = -INFINITY;
  for (const double v : table.column[c])
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  return {low, high};
}

bool GuessDraft::varies(std::size_t c) const {
  const auto [low, high] = range(c);
  return high > low;
}

double GuessDraft::rows_between_new_values(int c) const {
  if (c < 0 || time.is_null()) return 1.0;
  std::vector<double> t = values(column("time"));
  const double second = to_si("1 " + time.find("unit")->text(), "s");
  for (double& v : t) v *= second;
  return rows_between_new(t, values(c));
}

bool GuessDraft::falls(std::size_t c) const {
  double last = -INFINITY;
  for (const double v : table.column[c]) {
    if (v < last) return true;
    if (std::isfinite(v)) last = v;
  }
  return false;
}

std::string GuessDraft::candidates(bool rising) const {
  constexpr std::size_t most = 12;
  std::string all;
  std::size_t shown = 0;
  for (std::size_t c = 0; c < table.name.size(); ++c) {
    if (!varies(c) || taken(static_cast<int>(c)) || (rising && falls(c))) continue;
    if (++shown > most) continue;
    const auto [low, high] = range(c);
    all += (all.empty() ? "" : ", ") + table.name[c] + " (" + significant(low) + " to " + significant(high) + ")";
  }
  if (shown > most) all += " and " + std::to_string(shown - most) + " more";
  return all.empty() ? "no column is left that varies" : all;
}

bool GuessDraft::taken(int c) const {
  const auto names = [&](const Node& node) {
    const Node* const as_column = node.find("column");
    const Node* const formula = node.find("formula");
    return (as_column != nullptr && as_column->text() == name(c)) ||
           (formula != nullptr && has_name(formula->text(), quoted(c)));
  };
  return (time.is_object() && names(time)) ||
         std::ranges::any_of(channels.object(), [&](const Member& m) { return names(m.value); });
}

void GuessDraft::guess_column(const char* channel, const char* unit) {
  if (const int c = column(channel); c >= 0)
    channels.set(channel, guessed_channel("column", name(c), unit_of(c, unit)));
}

Node GuessDraft::unnamed(const char* channel, const char* what, const char* unit, bool rising) {
  open.emplace_back(channel);
  Node node = guessed_channel("column", unnamed_column, unit, false);
  node.set("note", Node(std::string("Fill in the column of ") + what + "; it may be one of: " + candidates(rising)));
  return node;
}

Node guessed_channel(const std::string& key, const std::string& what, const std::string& unit, bool delay) {
  Node node = Node::empty_object();
  node.set(key, Node(what));
  node.set("unit", Node(unit));
  if (delay) node.set("delay", Node("find"));
  return node;
}

double quantile_of_size(const std::vector<double>& values, double q) {
  std::vector<double> sizes;
  for (const double v : values)
    if (!std::isnan(v)) sizes.push_back(std::abs(v));
  return lower_quantile(std::move(sizes), q, 0.0);
}

}  // namespace gripline::measured
