#include "config/units.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "config/ascii.hpp"
#include "config/errors.hpp"
#include "config/node.hpp"

namespace gripline {
namespace {

struct Named {
  std::string_view name;
  Dimension dimension;
  double factor;
  bool takes_prefix;
};

constexpr double pi = std::numbers::pi;
constexpr std::string_view squared = "\xc2\xb2", cubed = "\xc2\xb3", dot = "\xc2\xb7";  // UTF-8

/// Whole exponents of m, kg, s, rad, A, K.
constexpr Dimension whole(int m, int kg, int s, int rad, int A, int K) {
  return {{2 * m, 2 * kg, 2 * s, 2 * rad, 2 * A, 2 * K}};
}

constexpr std::array<Named, 25> units{
    {{"m", whole(1, 0, 0, 0, 0, 0), 1.0, true},           {"g", whole(0, 1, 0, 0, 0, 0), 1e-3, true},
     {"s", whole(0, 0, 1, 0, 0, 0), 1.0, true},           {"min", whole(0, 0, 1, 0, 0, 0), 60.0, false},
     {"h", whole(0, 0, 1, 0, 0, 0), 3600.0, false},       {"rad", whole(0, 0, 0, 1, 0, 0), 1.0, true},
     {"deg", whole(0, 0, 0, 1, 0, 0), pi / 180.0, false}, {"\xc2\xb0", whole(0, 0, 0, 1, 0, 0), pi / 180.0, false},
     {"ft", whole(1, 0, 0, 0, 0, 0), 0.3048, false},      {"mi", whole(1, 0, 0, 0, 0, 0), 1609.344, false},
     {"mph", whole(1, 0, -1, 0, 0, 0), 0.44704, false},   {"kn", whole(1, 0, -1, 0, 0, 0), 1852.0 / 3600.0, false},
     {"rev", whole(0, 0, 0, 1, 0, 0), 2.0 * pi, false},   {"rpm", whole(0, 0, -1, 1, 0, 0), 2.0 * pi / 60.0, false},
     {"A", whole(0, 0, 0, 0, 1, 0), 1.0, true},           {"K", whole(0, 0, 0, 0, 0, 1), 1.0, true},
     {"Hz", whole(0, 0, -1, 0, 0, 0), 1.0, true},         {"N", whole(1, 1, -2, 0, 0, 0), 1.0, true},
     {"Pa", whole(-1, 1, -2, 0, 0, 0), 1.0, true},        {"bar", whole(-1, 1, -2, 0, 0, 0), 1e5, false},
     {"J", whole(2, 1, -2, 0, 0, 0), 1.0, true},          {"W", whole(2, 1, -3, 0, 0, 0), 1.0, true},
     {"V", whole(2, 1, -3, 0, -1, 0), 1.0, true},         {"ohm", whole(2, 1, -3, 0, -2, 0), 1.0, true},
     {"%", whole(0, 0, 0, 0, 0, 0), 1e-2, false}}};

constexpr std::array<std::pair<std::string_view, double>, 8> prefixes{
    {{"k", 1e3}, {"M", 1e6}, {"G", 1e9}, {"c", 1e-2}, {"m", 1e-3}, {"u", 1e-6}, {"\xc2\xb5", 1e-6}, {"n", 1e-9}}};

constexpr std::array<std::pair<Dimension, std::string_view>, 27> kinds{
    {{whole(0, 0, 0, 0, 0, 0), "a pure number"},
     {whole(1, 0, 0, 0, 0, 0), "a length"},
     {whole(2, 0, 0, 0, 0, 0), "an area"},
     {whole(3, 0, 0, 0, 0, 0), "a volume"},
     {whole(-1, 0, 0, 0, 0, 0), "a curvature"},
     {whole(0, 1, 0, 0, 0, 0), "a mass"},
     {whole(-3, 1, 0, 0, 0, 0), "a density"},
     {whole(2, 1, 0, 0, 0, 0), "a moment of inertia"},
     {whole(0, 0, 1, 0, 0, 0), "a time"},
     {whole(0, 0, -1, 0, 0, 0), "a frequency"},
     {whole(0, 0, 0, 1, 0, 0), "an angle"},
     {whole(0, 0, -1, 1, 0, 0), "an angular rate"},
     {whole(0, 0, -2, 1, 0, 0), "an angular acceleration"},
     {whole(1, 0, -1, 0, 0, 0), "a speed"},
     {whole(1, 0, -2, 0, 0, 0), "an acceleration"},
     {whole(1, 0, -3, 0, 0, 0), "a jerk"},
     {whole(1, 1, -2, 0, 0, 0), "a force"},
     {whole(0, 1, -2, 0, 0, 0), "a stiffness"},
     {whole(1, 1, -2, -1, 0, 0), "a force per angle"},
     {whole(0, 1, -1, 0, 0, 0), "a damping coefficient"},
     {whole(-1, 1, -2, 0, 0, 0), "a pressure"},
     {whole(2, 1, -2, 0, 0, 0), "a torque or an energy"},
     {whole(2, 1, -3, 0, 0, 0), "a power"},
     {whole(0, 0, 0, 0, 1, 0), "a current"},
     {whole(2, 1, -3, 0, -1, 0), "a voltage"},
     {whole(2, 1, -3, 0, -2, 0), "a resistance"},
     {whole(0, 0, 0, 0, 0, 1), "a temperature"}}};

constexpr std::array<std::pair<std::string_view, std::string_view>, 26> spelled_out{
    {{"sec", "s"},      {"secs", "s"},      {"second", "s"},    {"seconds", "s"}, {"msec", "ms"},  {"meter", "m"},
     {"meters", "m"},   {"metre", "m"},     {"metres", "m"},    {"feet", "ft"},   {"mile", "mi"},  {"miles", "mi"},
     {"degree", "deg"}, {"degrees", "deg"}, {"radians", "rad"}, {"percent", "%"}, {"kmh", "km/h"}, {"kph", "km/h"},
     {"kt", "kn"},      {"kts", "kn"},      {"knot", "kn"},     {"knots", "kn"},  {"mps", "m/s"},  {"dps", "deg/s"},
     {"Nm", "N m"},     {"Ns", "N s"}}};

std::string quoted(std::string_view text) { return Node(text).describe(); }

const Named* find_unit(std::string_view name) {
  const auto* it = std::ranges::find(units, name, &Named::name);
  return it == units.end() ? nullptr : it;
}

std::optional<Unit> find_prefixed(std::string_view name) {
  if (const Named* unit = find_unit(name)) return Unit{unit->dimension, unit->factor};
  for (const auto& [prefix, factor] : prefixes) {
    if (!name.starts_with(prefix)) continue;
    const Named* unit = find_unit(name.substr(prefix.size()));
    if (unit != nullptr && unit->takes_prefix) return Unit{unit->dimension, factor * unit->factor};
  }
  return std::nullopt;
}

/// a b^sign
Unit times(const Unit& a, const Unit& b, int sign) {
  Unit result{a.dimension, sign > 0 ? a.factor * b.factor : a.factor / b.factor};
  for (std::size_t i = 0; i < result.dimension.halves.size(); ++i) {
    result.dimension.halves[i] += sign * b.dimension.halves[i];
  }
  return result;
}

/// The square root, if its exponents are halves of whole numbers.
std::optional<Unit> root(const Unit& unit) {
  Unit result{unit.dimension, std::sqrt(unit.factor)};
  for (int& exponent : result.dimension.halves) {
    if (exponent % 2 != 0) return std::nullopt;
    exponent /= 2;
  }
  return result;
}

Unit power(const Unit& unit, int exponent) {
  Unit result;
  for (int i = 0; i < std::abs(exponent); ++i) result = times(result, unit, exponent > 0 ? 1 : -1);
  return result;
}

/// unit := factor { (" " | "*" | "/") factor };  factor := "1" | ( "(" unit ")" | name ) [ power ];  a power is a whole
/// number, or one and a half behind "^"
class UnitParser {
 public:
  explicit UnitParser(std::string_view text) : text_(text), rest_(text) {}

  Unit parse() {
    const Unit unit = product(0);
    if (!rest_.empty()) refuse("a closing bracket too many");
    return unit;
  }

 private:
  Unit product(int depth) {
    Unit result = factor(depth);
    bool divided = false;
    while (true) {
      const bool blank = skip_blanks();
      if (rest_.empty() || rest_.front() == ')') return result;
      const bool divide = take("/");
      const bool multiply = !divide && (take("*") || take(dot) || blank);
      if (!divide && !multiply) refuse("a blank or sign missing before " + quoted(rest_));
      if (multiply && divided) refuse("a product after a quotient needs brackets, as in \"N/(m s)\" or \"N s/m\",");
      divided = divided || divide;
      skip_blanks();
      result = bounded(times(result, factor(depth), divide ? -1 : 1));
    }
  }

  Unit factor(int depth) {
    constexpr int deepest = 8;
    if (depth > deepest) refuse("too many brackets");
    Unit unit;
    if (take("(")) {
      unit = product(depth + 1);
      if (!take(")")) refuse("a bracket is not closed");
    } else if (take_one()) {
      return unit;
    } else {
      unit = name();
    }
    const Exponent by = exponent();
    if (!by.half) return bounded(power(unit, by.whole));
    const std::optional<Unit> rooted = root(unit);
    if (!rooted) refuse("a root of a root");
    return bounded(power(*rooted, 2 * by.whole + (by.negative ? -1 : 1)));
  }

  /// Takes a bare 1, as in "1/s". It has no power, and no other number is a unit: "6 15 s" is not 6 s.
  bool take_one() {
    const std::string_view number = rest_.substr(0, rest_.find_first_not_of("0123456789."));
    if (number.empty() || number.front() == '.') return false;
    if (number != "1") refuse("the number " + std::string(number) + ", where a name belongs,");
    return take("1");
  }

  /// Refuses exponents that only repeated powers reach and that would overflow.
  Unit bounded(const Unit& unit) const {
    constexpr int highest = 200;  // halves
    const bool small = std::ranges::all_of(unit.dimension.halves, [](int h) { return std::abs(h) <= highest; });
    if (!small || !std::isfinite(unit.factor) || !(unit.factor > 0)) refuse("powers too high");
    return unit;
  }

  Unit name() {
    std::size_t length = 0;
    while (length < rest_.size() && is_letter(rest_.substr(length))) ++length;
    if (length == 0) refuse(rest_.empty() ? "a name is missing at the end" : "no name at " + quoted(rest_));
    const std::string name(rest_.substr(0, length));
    rest_.remove_prefix(length);
    if (const auto unit = find_prefixed(name)) return *unit;
    throw UnitError("unknown unit \"" + name + '"' + suggestion(name));
  }

  /// whole + 1/2 away from zero when `half`.
  struct Exponent {
    int whole = 1;
    bool half = false, negative = false;
  };
  Exponent exponent() {
    if (take(squared)) return {2};
    if (take(cubed)) return {3};
    const bool caret = take("^");
    constexpr std::string_view wanted = "a power is a whole number from 1 to 9, or a half such as ^0.5";
    Exponent result;
    result.negative = rest_.starts_with('-');
    const auto [stop, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), result.whole);
    constexpr int highest = 9;
    if (error == std::errc::invalid_argument && !caret) return {};
    if (error != std::errc() || std::abs(result.whole) > highest) refuse(std::string(wanted));
    rest_.remove_prefix(static_cast<std::size_t>(stop - rest_.data()));
    result.half = caret && take(".5");
    if (result.whole == 0 && !result.half) refuse(std::string(wanted));
    return result;
  }

  /// Whether a name goes on here. Powers and the product dot are the signs beyond ASCII that are not letters.
  static bool is_letter(std::string_view rest) {
    const char c = rest.front();
    if (rest.starts_with(squared) || rest.starts_with(cubed) || rest.starts_with(dot)) return false;
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '%' || static_cast<unsigned char>(c) >= 0x80;
  }

  static std::string suggestion(const std::string& name) {
    const auto* known = std::ranges::find(spelled_out, name, &std::pair<std::string_view, std::string_view>::first);
    if (known != spelled_out.end()) return "; did you mean \"" + std::string(known->second) + "\"?";
    std::vector<std::string> names{"km", "cm", "mm", "kg", "ms", "kN", "mrad", "kW", "MPa", "kPa"};
    for (const Named& one : units) names.emplace_back(one.name);
    const auto near = nearest(name, names);
    return near ? "; did you mean \"" + *near + "\"?" : "";
  }

  bool take(std::string_view token) {
    if (!rest_.starts_with(token)) return false;
    rest_.remove_prefix(token.size());
    return true;
  }

  bool skip_blanks() {
    const std::size_t length = std::min(rest_.find_first_not_of(' '), rest_.size());
    rest_.remove_prefix(length);
    return length > 0;
  }

  [[noreturn]] void refuse(const std::string& reason) const {
    throw UnitError(reason + " in the unit " + quoted(text_));
  }

  std::string_view text_;
  std::string_view rest_;
};

/// "degrees/sec" as "deg/s".
std::string abbreviated(std::string_view unit) {
  std::string out;
  while (true) {
    const std::size_t slash = unit.find('/');
    const std::string_view part = unit.substr(0, slash);
    const auto* const known =
        std::ranges::find(spelled_out, part, &std::pair<std::string_view, std::string_view>::first);
    out += known != spelled_out.end() ? known->second : part;
    if (slash == std::string_view::npos) return out;
    out += '/';
    unit.remove_prefix(slash + 1);
  }
}

}  // namespace

Unit Unit::parse(std::string_view text) {
  const std::string_view body = trim(text, " ");
  if (body.empty() || body == "-") return {};
  return UnitParser(body).parse();
}

std::string describe(const Dimension& dimension) {
  const auto* kind = std::ranges::find(kinds, dimension, &std::pair<Dimension, std::string_view>::first);
  if (kind != kinds.end()) return std::string(kind->second);
  constexpr std::array<std::string_view, 6> symbols{"m", "kg", "s", "rad", "A", "K"};
  std::string above, below;
  int factors_below = 0;
  for (std::size_t i = 0; i < symbols.size(); ++i) {
    const int halves = dimension.halves[i];
    if (halves == 0) continue;
    std::string& side = halves > 0 ? above : below;
    if (!side.empty()) side += ' ';
    side += symbols[i];
    const int size = std::abs(halves);
    if (size % 2 != 0) {
      side += '^' + std::to_string(size / 2) + ".5";
    } else if (size > 2) {
      side += std::to_string(size / 2);
    }
    if (halves < 0) ++factors_below;
  }
  if (factors_below > 1) below = '(' + below + ')';
  return "a quantity in " + (above.empty() ? "1" : above) + (below.empty() ? "" : '/' + below);
}

std::string expectation(std::string_view unit) {
  const Dimension dimension = Unit::parse(unit).dimension;
  const std::string kind = describe(dimension);
  if (dimension == Dimension{}) return "expected " + kind;
  return "expected " + (kind.starts_with("a quantity") ? "a quantity" : kind) + " [" + std::string(unit) + ']';
}

double to_si(std::string_view text, std::string_view expected_unit) {
  const std::string_view body = trim(text, " ");
  const Dimension expected = [&] {
    try {
      return Unit::parse(expected_unit).dimension;
    } catch (const UnitError& error) {
      throw std::logic_error(error.what());
    }
  }();
  double value = 0.0;
  const char* const end = body.data() + body.size();
  const auto [stop, error] = std::from_chars(body.data(), end, value);
  if (error == std::errc::result_out_of_range)
    throw UnitError(quoted(text) + " is too large or too small for a number");
  if (error != std::errc() || !std::isfinite(value)) {
    throw UnitError(quoted(text) + " is not a finite number with a unit, " + expectation(expected_unit));
  }
  const std::string number(body.data(), stop);
  const std::string_view rest = trim({stop, static_cast<std::size_t>(end - stop)}, " ");
  if (rest.starts_with(',')) throw UnitError(quoted(text) + " has a comma; the decimal mark is a point");
  if (rest.empty()) {
    if (expected == Dimension{}) throw UnitError(quoted(text) + " is text: write " + number + " without quotes");
    throw UnitError(quoted(text) + " has no unit: write " + number + " without quotes, or \"" + number + ' ' +
                    std::string(expected_unit) + '"');
  }
  const Unit unit = [&] {
    try {
      return Unit::parse(rest);
    } catch (const UnitError& error) {
      const std::string reason = error.what();
      throw UnitError(quoted(text) + ": " + reason + (reason.ends_with('?') ? "" : "; " + expectation(expected_unit)));
    }
  }();
  if (unit.dimension != expected) {
    throw UnitError(quoted(text) + " is " + describe(unit.dimension) + ", " + expectation(expected_unit));
  }
  const double si = value * unit.factor;
  if (!std::isfinite(si)) throw UnitError(quoted(text) + " is too large for a number");
  return si;
}

std::string header_unit(std::string_view written, std::string_view expected_unit, bool any_form) {
  const Dimension expected = Unit::parse(expected_unit).dimension;
  std::string unit(trim(written, " "));
  for (std::size_t at; (at = unit.find("\xc2\xb0")) != std::string::npos;) unit.replace(at, 2, "deg");
  std::vector<std::string> readings{unit};
  if (any_form) {
    const std::string lower = lower_case(unit);
    readings.insert(readings.end(), {lower, abbreviated(unit), abbreviated(lower)});
  }
  for (const std::string& reading : readings) {
    try {
      if (!reading.empty() && Unit::parse(reading).dimension == expected) return reading;
    } catch (const UnitError&) {  // the next reading
    }
  }
  return {};
}

}  // namespace gripline
