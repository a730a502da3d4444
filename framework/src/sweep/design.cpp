#include "sweep/design.hpp"

#include <algorithm>
#include <bit>
#include <boost/algorithm/string/replace.hpp>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <set>
#include <sstream>

#include "config/ascii.hpp"
#include "config/errors.hpp"
#include "config/files.hpp"
#include "config/json_file.hpp"
#include "experiment/experiment.hpp"
#include "util/numbers.hpp"

namespace gripline::sweep {
namespace {

constexpr std::size_t most_settings = 10'000'000;

/// splitmix64 (Steele, Lea, Flood, "Fast splittable pseudorandom number generators", 2014): the finaliser.
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31U);
}

/// "lo..hi" with both ends numbers.
std::optional<std::pair<double, double>> range_of(const std::string& text) {
  const std::size_t dots = text.find("..");
  if (dots == std::string::npos) return std::nullopt;
  const std::string_view whole = text;
  const auto lo = parse_number(trim(whole.substr(0, dots))), hi = parse_number(trim(whole.substr(dots + 2)));
  if (!lo || !hi || !std::isfinite(*lo) || !std::isfinite(*hi)) return std::nullopt;
  return std::pair(*lo, *hi);
}

/// A value of a range that stays in [lo, hi): a value of a table, and still exactly what is raced. Six significant
/// digits, and more where these would leave the part or move the value by more than a thousandth of the range.
std::string short_text(double value, double lo, double hi, double width) {
  for (int digits = 6; digits < 17; ++digits) {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, digits).ptr;
    double rounded = 0;
    std::from_chars(text, end, rounded);
    if (rounded >= lo && rounded < hi && std::abs(rounded - value) <= 1e-3 * width) return {text, end};
  }
  return number_text(value);
}

/// Value of a range at `within` (0 to 1) of its part `part` of `count`.
std::string value_within(const Factor& factor, std::uint64_t part, double within, std::size_t count) {
  const double width = factor.hi - factor.lo;
  const auto at = [&](double place) {
    return std::clamp(factor.lo + place / static_cast<double>(count) * width, factor.lo, factor.hi);
  };
  const auto first = static_cast<double>(part);
  return short_text(at(first + within), at(first), at(first + 1), width);
}

/// What no setting can change: runs name their own seed, and claims judge runs.
void require_input(const Factor& factor, const std::string& member) {
  if (member == "seeds" || member == "seed")
    throw InputError(factor.pointer +
                     ": seeds are no factor, as every setting is run with the same ones; use --seeds " +
                     "1..50 or 1,2,7");
  if (member == "claims" || member == "claim_share")
    throw InputError(factor.pointer + ": claims are no factor: they change no run, and a sweep judges none; to " +
                     "repeat runs use --seeds 1..50 or 1,2,7");
}

void require_pointers(const std::vector<Factor>& factors) {
  std::set<std::string> seen;
  for (const Factor& factor : factors) {
    const std::vector<std::string> names = split_pointer(factor.pointer);
    if (names.empty()) throw InputError("a factor needs a JSON pointer such as /base/planner/params/pace");
    if (names.back() == "-")
      throw InputError(factor.pointer + ": a factor replaces a value; \"-\" would add one more in every setting");
    require_input(factor, names.front());
    if (!seen.insert(factor.pointer).second) throw InputError(factor.pointer + " is a factor twice");
  }
}

bool is_json(const std::string& text) {
  try {
    (void)parse_text(text);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

/// A list or an object of JSON in a cell that is quoted as RFC 4180 has it, as spreadsheets do: "{""t"": 0}". Any other
/// cell is itself, also one whose text only begins like JSON: "[dry], wet".
std::string unquoted(const std::string& cell) {
  if (cell.size() < 4 || cell.back() != '"' || !(cell.starts_with("\"{") || cell.starts_with("\"["))) return cell;
  std::string inside = boost::algorithm::replace_all_copy(cell.substr(1, cell.size() - 2), "\"\"", "\"");
  return is_json(inside) ? inside : cell;
}

/// A cell that is quoted and closed as JSON is, but does not read as JSON: a slip, not a word.
void require_json_or_word(const std::string& cell) {
  const bool closed =
      (cell.starts_with("\"{") && cell.ends_with("}\"")) || (cell.starts_with("\"[") && cell.ends_with("]\""));
  if (closed && cell.find("\"\"") != cell.npos && unquoted(cell) == cell)
    throw InputError("expected JSON in quotes as spreadsheets write it, such as \"{\"\"t\"\": 0}\", found " + cell);
}

bool names_factor(const std::string& assignment) { return assignment.find('=') == std::string::npos; }

/// Whether what stands at `pointer` is within what stands at `whole`, or is the same.
bool is_within(std::string_view pointer, std::string_view whole) {
  return pointer.starts_with(whole) && (pointer.size() == whole.size() || pointer[whole.size()] == '/');
}

std::uint64_t seed_number(const std::string& text, const std::string& all) {
  std::uint64_t value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size() || value > static_cast<std::uint64_t>(largest_seed))
    throw InputError("--seeds " + all + ": expected whole numbers up to " + std::to_string(largest_seed) +
                     " such as 1..50 or 1,2,7, found \"" + text + "\"");
  return value;
}

}  // namespace

std::vector<std::string> split_levels(std::string_view text) {
  std::vector<std::string> levels(1);
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '\\' && i + 1 < text.size()) levels.back() += text[i++];
    if (c == '"') quoted = !quoted;
    if (!quoted && (c == '[' || c == '{')) ++depth;
    if (!quoted && (c == ']' || c == '}')) --depth;
    if (c == ',' && depth <= 0 && !quoted)
      levels.emplace_back();
    else
      levels.back() += text[i];
  }
  for (std::string& level : levels) {
    level = std::string(trim(level));
    if (level.empty()) throw InputError("\"" + std::string(text) + "\": a value is missing between commas");
  }
  return levels;
}

Factor parse_factor(const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos || !assignment.starts_with('/'))
    throw InputError("--set " + assignment + ": expected /json/pointer=a,b,c");
  Factor factor;
  factor.pointer = assignment.substr(0, equals);
  const std::string text = assignment.substr(equals + 1);
  if (const auto range = range_of(text)) {
    factor.lo = range->first;
    factor.hi = range->second;
    if (!(factor.lo < factor.hi))
      throw InputError("--set " + assignment + ": a range rises from its left to its right");
    return factor;
  }
  try {
    factor.levels = split_levels(text);
  } catch (const InputError& error) {
    throw InputError("--set " + factor.pointer + ": " + error.what());
  }
  std::set<std::string> seen;
  for (const std::string& level : factor.levels)
    if (!seen.insert(level).second) throw InputError("--set " + factor.pointer + ": " + level + " is there twice");
  return factor;
}

std::vector<std::uint64_t> parse_seeds(const std::string& text) {
  constexpr std::size_t most = 1'000'000;
  std::vector<std::uint64_t> seeds;
  for (const std::string& part : split_levels(text)) {
    const std::size_t dots = part.find("..");
    const std::uint64_t first = seed_number(std::string(trim(part.substr(0, dots))), text);
    const std::uint64_t last =
        dots == std::string::npos ? first : seed_number(std::string(trim(part.substr(dots + 2))), text);
    if (last < first) throw InputError(("--seeds " + text).append(": ").append(part).append(" ends before it begins"));
    if (seeds.size() + (last - first) >= most)
      throw InputError("--seeds " + text + ": at most " + std::to_string(most) + " seeds");
    for (std::uint64_t seed = first; seed <= last; ++seed) seeds.push_back(seed);
  }
  std::vector<std::uint64_t> sorted = seeds;
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end()) throw InputError("--seeds " + text + ": " + std::to_string(*twice) + " is there twice");
  return seeds;
}

std::vector<std::string> assignments_of(const std::vector<std::string>& given, const Design& design,
                                        const std::vector<std::string>& values) {
  const std::vector<Factor>& factors = design.factors();
  std::vector<std::string> all;
  std::set<std::string_view> named;
  for (const std::string& one : given) {
    if (!names_factor(one)) {
      all.push_back(one);
      continue;
    }
    const auto factor = std::ranges::find(factors, one, &Factor::pointer);
    if (factor == factors.end()) throw InputError("--set " + one + ": expected /json/pointer=VALUE");
    all.push_back(one + "=" + values[static_cast<std::size_t>(factor - factors.begin())]);
    named.insert(one);
  }
  for (std::size_t f = 0; f < factors.size(); ++f)
    if (!named.contains(factors[f].pointer)) all.push_back(factors[f].pointer + "=" + values[f]);
  return all;
}

std::vector<std::string> assignments_of(const std::vector<std::string>& given, const Design& design,
                                        std::size_t setting) {
  return assignments_of(given, design, design.setting(setting));
}

std::size_t constants_before_factors(const std::vector<std::string>& given) {
  return static_cast<std::size_t>(std::ranges::find_if(given, names_factor) - given.begin());
}

void require_effect(const std::vector<std::string>& given, const Design& design) {
  const bool list = design.kind() == Design::Kind::list;
  std::vector<std::string_view> factors;  // so far
  const auto use = [&](std::string_view pointer) {
    for (const std::string_view factor : factors)
      if (is_within(factor, pointer))
        throw InputError(std::string(pointer) + " replaces what the factor " + std::string(factor) +
                         " sets before it; name it first");
  };
  for (const std::string& one : given) {
    const std::string_view pointer = std::string_view(one).substr(0, one.find('='));
    use(pointer);
    if (names_factor(one)) factors.push_back(pointer);
    for (const Factor& column : design.factors())
      if (list && pointer != column.pointer && is_within(pointer, column.pointer))
        throw InputError("--set " + std::string(pointer) + ": the list replaces " + column.pointer +
                         " in every setting, and this with it; make it a column behind that one");
  }
  for (const Factor& factor : design.factors())
    if (std::ranges::find(factors, factor.pointer) == factors.end()) {
      use(factor.pointer);
      factors.push_back(factor.pointer);
    }
}

std::uint64_t permuted(std::uint64_t index, std::uint64_t count, std::uint64_t seed) {
  if (count < 2) return index;
  const auto half = static_cast<unsigned>((std::bit_width(count - 1) + 1) / 2);
  const std::uint64_t mask = (std::uint64_t{1} << half) - 1;
  do {
    std::uint64_t left = index >> half, right = index & mask;
    for (std::uint64_t round = 0; round < 6; ++round) {
      const std::uint64_t next = left ^ (mixed(right ^ mixed(seed + round)) & mask);
      left = right;
      right = next;
    }
    index = (left << half) | right;
  } while (index >= count);
  return index;
}

Design Design::factorial(std::vector<Factor> factors) {
  require_pointers(factors);
  Design design;
  for (const Factor& factor : factors) {
    if (factor.range())
      throw InputError("--set " + factor.pointer + "=" + number_text(factor.lo) + ".." + number_text(factor.hi) +
                       ": a range has values in a latin hypercube only; add --latin COUNT or list its values");
    if (design.size_ > most_settings / factor.levels.size())
      throw InputError("more than " + std::to_string(most_settings) + " settings; use fewer values or --latin COUNT");
    design.size_ *= factor.levels.size();
  }
  design.factors_ = std::move(factors);
  return design;
}

Design Design::latin(std::vector<Factor> factors, std::size_t count, std::uint64_t seed) {
  require_pointers(factors);
  if (count < 1 || count > most_settings)
    throw InputError("--latin " + std::to_string(count) + ": expected 1 to " + std::to_string(most_settings));
  if (factors.empty()) throw InputError("--latin needs at least one --set /pointer=lo..hi");
  Design design;
  design.kind_ = Kind::latin;
  design.factors_ = std::move(factors);
  design.size_ = count;
  design.seed_ = seed;
  return design;
}

Design Design::list(const std::filesystem::path& file) {
  Design design;
  design.kind_ = Kind::list;
  design.file_ = shown(file);
  std::istringstream lines(read_bytes(file));
  int number = 0;
  const auto cells_of = [&](const std::string& line) {
    try {
      std::vector<std::string> cells = split_levels(line);
      for (const std::string& cell : cells) require_json_or_word(cell);
      return cells;
    } catch (const InputError& error) {
      throw InputError({Diagnostic{shown(file), number, 1, "", error.what(), {}}});
    }
  };
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (number == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
    const std::string row(trim(line));
    if (row.empty()) continue;
    const std::vector<std::string> cells = cells_of(row);
    if (design.factors_.empty()) {
      for (const std::string& cell : cells) {
        if (!cell.starts_with('/'))
          throw InputError({Diagnostic{shown(file),
                                       number,
                                       1,
                                       "",
                                       "expected JSON pointers such as /base/mu_init in the first row, found " + cell,
                                       {}}});
        design.factors_.push_back({cell, {}, 0, 0});
      }
      continue;
    }
    if (cells.size() != design.factors_.size())
      throw InputError({Diagnostic{
          shown(file),
          number,
          1,
          "",
          "expected " + std::to_string(design.factors_.size()) + " values, found " + std::to_string(cells.size()),
          {}}});
    design.rows_.push_back(row);
    design.lines_.push_back(number);
  }
  require_pointers(design.factors_);
  if (design.rows_.empty()) throw InputError(shown(file) + ": expected a row of JSON pointers and rows of values");
  design.size_ = design.rows_.size();
  return design;
}

std::vector<std::string> Design::setting(std::size_t index) const {
  if (kind_ == Kind::list) {
    std::vector<std::string> cells = split_levels(rows_.at(index));
    for (std::string& cell : cells) cell = unquoted(cell);
    return cells;
  }
  std::vector<std::string> values(factors_.size());
  if (kind_ == Kind::factorial) {
    for (std::size_t f = factors_.size(); f-- > 0;) {
      values[f] = factors_[f].levels[index % factors_[f].levels.size()];
      index /= factors_[f].levels.size();
    }
    return values;
  }
  for (std::size_t f = 0; f < factors_.size(); ++f) {
    const std::uint64_t own = mixed(seed_ ^ mixed(f + 1));
    const double within = static_cast<double>(mixed(own ^ mixed(index)) >> 11U) * 0x1p-53;
    const std::uint64_t part = permuted(index, size_, own);
    const double share = (static_cast<double>(part) + within) / static_cast<double>(size_);
    const Factor& factor = factors_[f];
    const auto level = static_cast<std::size_t>(share * static_cast<double>(factor.levels.size()));
    values[f] = factor.range() ? value_within(factor, part, within, size_)
                               : factor.levels[std::min(level, factor.levels.size() - 1)];
  }
  return values;
}

std::optional<ListPlace> Design::place(std::size_t index, std::size_t factor) const {
  if (index >= lines_.size()) return std::nullopt;
  const std::string& row = rows_[index];
  const std::vector<std::string> cells = split_levels(row);
  std::size_t begin = 0;
  for (std::size_t f = 0; f <= factor; ++f) {  // between two cells there are only a comma and blanks
    if (f > 0) begin += cells[f - 1].size();
    begin = row.find(cells.at(f), begin);
  }
  const auto letters = std::count_if(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(begin),
                                     [](char c) { return (c & 0xc0) != 0x80; });
  return ListPlace{file_, lines_[index], 1 + static_cast<int>(letters)};
}

Node Design::to_node() const {
  Node node = Node::empty_object();
  constexpr const char* names[] = {"factorial", "latin", "list"};
  node.set("kind", Node(names[static_cast<std::size_t>(kind_)]));
  Node::Array factors;
  for (const Factor& factor : factors_) {
    Node one = Node::empty_object();
    one.set("pointer", Node(factor.pointer));
    Node::Array levels;
    for (const std::string& level : factor.levels) levels.emplace_back(level);
    one.set("levels", Node(std::move(levels)));
    one.set("lo", Node(factor.lo));
    one.set("hi", Node(factor.hi));
    factors.push_back(std::move(one));
  }
  node.set("factors", Node(std::move(factors)));
  node.set("size", Node(static_cast<double>(size_)));
  node.set("seed", Node(static_cast<double>(seed_)));
  Node::Array rows;
  for (const std::string& row : rows_) rows.emplace_back(row);
  node.set("rows", Node(std::move(rows)));
  return node;
}

Design Design::from_node(const Node& node) {
  Design design;
  const std::string kind = node.at("kind").text();
  design.kind_ = kind == "latin" ? Kind::latin : kind == "list" ? Kind::list : Kind::factorial;
  for (const Node& one : node.at("factors").array()) {
    Factor factor{one.at("pointer").text(), {}, one.at("lo").number(), one.at("hi").number()};
    for (const Node& level : one.at("levels").array()) factor.levels.push_back(level.text());
    design.factors_.push_back(std::move(factor));
  }
  design.size_ = static_cast<std::size_t>(node.at("size").number());
  design.seed_ = static_cast<std::uint64_t>(node.at("seed").number());
  for (const Node& row : node.at("rows").array()) design.rows_.push_back(row.text());
  return design;
}

}  // namespace gripline::sweep
