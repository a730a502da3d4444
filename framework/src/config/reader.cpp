#include "config/reader.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "config/files.hpp"
#include "config/json_file.hpp"
#include "config/shipped.hpp"
#include "config/units.hpp"

namespace gripline {
namespace {

constexpr std::int64_t largest_exact = (std::int64_t{1} << 53) - 1;  // whole numbers a double still tells apart

std::string with_unit(double value, std::string_view unit) {
  const bool pure = unit.empty() || unit == "1" || unit == "-";
  if (std::isinf(value)) return value < 0 ? "-infinity" : "infinity";
  return number_text(value) + (pure ? "" : ' ' + std::string(unit));
}

/// "above 0 s", "at least 0 s", "from 0 s to 1 s"
std::string range_text(const NumberRange& range, std::string_view unit) {
  const bool has_lo = std::isfinite(range.lo), has_hi = std::isfinite(range.hi);
  std::string text;
  if (has_lo && has_hi && !range.lo_open && !range.hi_open) {
    return "from " + with_unit(range.lo, unit) + " to " + with_unit(range.hi, unit);
  }
  if (has_lo) text = (range.lo_open ? "above " : "at least ") + with_unit(range.lo, unit);
  if (has_lo && has_hi) text += " and ";
  if (has_hi) text += (range.hi_open ? "below " : "at most ") + with_unit(range.hi, unit);
  return text;
}

std::string integer_expectation(const IntegerRange& range) {
  const bool has_lo = range.lo > -largest_exact, has_hi = range.hi < largest_exact;
  std::string text = "expected a whole number";
  if (has_lo && has_hi) return text + " from " + std::to_string(range.lo) + " to " + std::to_string(range.hi);
  if (has_lo) text += " of at least " + std::to_string(range.lo);
  if (has_hi) text += " of at most " + std::to_string(range.hi);
  return text;
}

/// `"a", "b" or "c"`
std::string one_of(std::span<const std::string> names) {
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const char* const separator = i == 0 ? "" : i + 1 == names.size() ? " or " : ", ";
    list += separator + ('"' + names[i] + '"');
  }
  return list;
}

/// `{"extends": "worlds/ethz.json", "laps": 1}`: how an object is written that changes keys of a file.
std::string as_extension(const Node& patch, const std::filesystem::path& file) {
  const std::filesystem::path folder = patch.origin.source ? patch.origin.source->folder : std::filesystem::path();
  std::string text = "{\"extends\": \"" + name_from(file, folder) + '"';
  const Node::Object& members = patch.object();
  const bool whole = members.size() == 1 && !members.front().value.is_object() && !members.front().value.is_array();
  if (whole) return text + ", \"" + members.front().key + "\": " + members.front().value.describe() + '}';
  return text + (members.empty() ? "}" : ", ...}");
}

void wrong(const Node& node, const std::string& expected, Errors& errors) {
  errors.add(node.origin, expected + ", found " + node.describe());
}

}  // namespace

double NumberRange::some() const {
  if (contains(0.0)) return 0.0;
  if (std::isfinite(lo) && contains(lo)) return lo;
  if (std::isfinite(hi) && contains(hi)) return hi;
  if (std::isfinite(lo) && std::isfinite(hi)) return 0.5 * (lo + hi);
  return std::isfinite(lo) ? lo + 1.0 : hi - 1.0;
}

double read_number(const Node& node, std::string_view unit, const NumberRange& range, Errors& errors) {
  double value = 0.0;
  if (node.is_number()) {
    value = node.number();
  } else if (node.is_text()) {
    try {
      value = to_si(node.text(), unit);
    } catch (const UnitError& error) {
      errors.add(node.origin, error.what());
      return range.some();
    }
  } else {
    wrong(node, expectation(unit), errors);
    return range.some();
  }
  if (!std::isfinite(value)) {
    errors.add(node.origin, node.describe() + " is too large for a number: " + expectation(unit));
    return range.some();
  }
  if (range.contains(value)) return value;
  errors.add(node.origin, node.describe() + " is out of range: " + expectation(unit) + ' ' + range_text(range, unit));
  return range.some();
}

std::int64_t read_integer(const Node& node, const IntegerRange& range, Errors& errors) {
  const double value = node.is_number() ? node.number() : 0.5;
  const bool whole = std::trunc(value) == value && std::abs(value) <= static_cast<double>(largest_exact);
  if (whole) {
    const auto integer = static_cast<std::int64_t>(value);
    if (integer >= range.lo && integer <= range.hi) return integer;
  }
  wrong(node, integer_expectation(range), errors);
  return std::clamp<std::int64_t>(0, range.lo, range.hi);
}

bool read_boolean(const Node& node, Errors& errors) {
  if (node.is_boolean()) return node.boolean();
  wrong(node, "expected true or false", errors);
  return false;
}

std::string read_text(const Node& node, Errors& errors) {
  if (node.is_text()) return node.text();
  wrong(node, "expected a text", errors);
  return "";
}

std::size_t read_choice(const Node& node, std::span<const std::string> names, Errors& errors) {
  const auto known = node.is_text() ? std::ranges::find(names, node.text()) : names.end();
  if (known != names.end()) return static_cast<std::size_t>(known - names.begin());
  // In place of a long list of names the message has the nearest one.
  constexpr std::size_t most = 6;
  const bool hint = node.is_text() && names.size() > most;
  if (hint) {
    errors.add(node.origin, "unknown name " + node.describe() + did_you_mean(node.text(), names));
  } else {
    wrong(node, "expected " + one_of(names), errors);
  }
  return 0;
}

std::span<const Node> read_array(const Node& node, Errors& errors) {
  if (node.is_array()) return node.array();
  wrong(node, "expected an array", errors);
  return {};
}

std::vector<double> read_numbers(const Node& node, std::string_view unit, const NumberRange& range,
                                 std::optional<std::size_t> count, Errors& errors) {
  std::vector<double> values;
  if (!node.is_array() || (count && node.array().size() != *count)) {
    const std::string numbers = count ? "an array of " + std::to_string(*count) + " numbers" : "an array of numbers";
    const std::string found = node.is_array() ? "one of " + std::to_string(node.array().size()) : node.describe();
    errors.add(node.origin, "expected " + numbers + ", found " + found);
    values.assign(count.value_or(0), range.some());
    return values;
  }
  for (const Node& one : node.array()) values.push_back(read_number(one, unit, range, errors));
  return values;
}

ObjectReader::ObjectReader(const Node& node, Errors& errors) : ObjectReader(node, errors, false) {}

ObjectReader::ObjectReader(const Node& node, Errors& errors, bool missing)
    : node_(node), errors_(errors), silent_(missing || !node.is_object()) {
  if (!missing && silent_) wrong(node, "expected an object", errors);
}

ObjectReader::~ObjectReader() { finish(); }

void ObjectReader::asked(std::string_view key) {
  if (std::ranges::find(asked_, key) == asked_.end()) asked_.emplace_back(key);
}

const Node* ObjectReader::find(std::string_view key) {
  asked(key);
  const Node* node = node_.find(key);
  return node == nullptr || node->is_null() ? nullptr : node;
}

bool ObjectReader::has(std::string_view key) { return find(key) != nullptr; }

const Node* ObjectReader::require(std::string_view key, std::string_view expected) {
  const Node* node = find(key);
  if (node == nullptr && !silent_) tell_missing(key, expected);
  return node;
}

/// The file whose name this object took the place of, if it is not merged over another one: of that, members stand
/// elsewhere.
std::optional<std::filesystem::path> ObjectReader::replaced_file() const {
  if (!node_.replaced || !node_.replaced->is_text() || !node_.replaced->text().ends_with(".json")) return std::nullopt;
  const auto is_elsewhere = [&](const Member& one) { return one.value.origin.source != node_.origin.source; };
  if (std::ranges::any_of(node_.object(), is_elsewhere)) return std::nullopt;
  std::filesystem::path file = resolve_path(*node_.replaced);
  if (!why_unreadable(file).empty()) return std::nullopt;
  return file;
}

void ObjectReader::tell_missing(std::string_view key, std::string_view expected) {
  if (const auto file = replaced_file()) {
    lacks_replaced_file_ = true;
    const Source* const of = node_.replaced->origin.source.get();
    errors_.add(node_.origin, "replaces the file \"" + node_.replaced->text() + '"' +
                                  (of != nullptr ? " of " + of->name : std::string()) +
                                  "; to change keys of it write " + as_extension(node_, *file));
    return;
  }
  const std::string what =
      expected.starts_with("expected") ? std::string(expected) : "expected " + std::string(expected);
  errors_.add(child_of(node_.origin, key), "missing, " + what);
}

double ObjectReader::number(std::string_view key, std::string_view unit, const NumberRange& range,
                            std::optional<double> fallback) {
  if (const Node* node = fallback ? find(key) : require(key, expectation(unit))) {
    return read_number(*node, unit, range, errors_);
  }
  return fallback.value_or(range.some());
}

std::optional<double> ObjectReader::optional_number(std::string_view key, std::string_view unit,
                                                    const NumberRange& range) {
  const Node* node = find(key);
  return node == nullptr ? std::nullopt : std::optional(read_number(*node, unit, range, errors_));
}

std::int64_t ObjectReader::integer(std::string_view key, const IntegerRange& range,
                                   std::optional<std::int64_t> fallback) {
  if (const Node* node = fallback ? find(key) : require(key, integer_expectation(range))) {
    return read_integer(*node, range, errors_);
  }
  return fallback.value_or(std::clamp<std::int64_t>(0, range.lo, range.hi));
}

bool ObjectReader::boolean(std::string_view key, std::optional<bool> fallback) {
  if (const Node* node = fallback ? find(key) : require(key, "true or false")) return read_boolean(*node, errors_);
  return fallback.value_or(false);
}

std::string ObjectReader::text(std::string_view key, const std::optional<std::string>& fallback) {
  if (const Node* node = fallback ? find(key) : require(key, "a text")) return read_text(*node, errors_);
  return fallback.value_or("");
}

std::string ObjectReader::choice(std::string_view key, std::span<const std::string> names,
                                 const std::optional<std::string>& fallback) {
  if (const Node* node = fallback ? find(key) : require(key, one_of(names))) {
    return names[read_choice(*node, names, errors_)];
  }
  return fallback.value_or(names.front());
}

std::filesystem::path ObjectReader::path(std::string_view key) {
  const Node* node = require(key, "the path of a file");
  if (node == nullptr) return {};
  if (node->is_text() && !node->text().empty()) return resolve_path(*node);
  wrong(*node, "expected the path of a file", errors_);
  return {};
}

std::filesystem::path ObjectReader::input_file(std::string_view key) {
  std::filesystem::path file = path(key);
  if (file.empty()) return file;
  const Node& name = *node_.find(key);
  if (const std::string reason = why_unreadable_as(name.text(), file); !reason.empty()) {
    error_at(key, name.describe() + ": " + reason);
  }
  return file;
}

std::filesystem::path ObjectReader::input_file(std::string_view key, std::span<const std::string_view> endings) {
  std::filesystem::path file = path(key);
  if (file.empty()) return file;
  const Node& name = *node_.find(key);
  if (const std::string reason = why_no_input(name, endings); !reason.empty()) {
    error_at(key, name.describe() + ": " + reason);
  }
  return file;
}

std::span<const Node> ObjectReader::array(std::string_view key, bool required) {
  const Node* node = required ? require(key, "an array") : find(key);
  return node == nullptr ? std::span<const Node>() : read_array(*node, errors_);
}

std::vector<double> ObjectReader::numbers(std::string_view key, std::string_view unit, const NumberRange& range,
                                          std::optional<std::size_t> count) {
  const Node* node = require(key, "an array of numbers");
  if (node != nullptr) return read_numbers(*node, unit, range, count, errors_);
  return std::vector<double>(count.value_or(0), range.some());
}

ObjectReader ObjectReader::object(std::string_view key) {
  static const Node nothing(Node::Object{});
  const Node* node = require(key, "an object");
  if (node != nullptr) return {*node, errors_};
  return {nothing, errors_, true};
}

std::vector<const Member*> ObjectReader::members() {
  std::vector<const Member*> result;
  if (!node_.is_object()) return result;
  for (const Member& one : node_.object()) {
    if (one.key == "note") continue;
    asked(one.key);
    if (!one.value.is_null()) result.push_back(&one);
  }
  return result;
}

void ObjectReader::error_at(std::string_view key, std::string message) {
  const Node* node = node_.find(key);
  errors_.add(node != nullptr ? node->origin : child_of(node_.origin, key), std::move(message));
}

void ObjectReader::finish() {
  if (std::exchange(finished_, true) || silent_) return;
  for (const Member& one : node_.object()) {
    const bool removed = one.value.is_null() && one.value.replaced;  // a key of the file that was extended
    if (one.key == "note") {
      check_note(one.value);
    } else if (removed) {
      continue;
    } else if (std::ranges::find(asked_, one.key) == asked_.end()) {
      errors_.add(one.key_origin(), "unknown key \"" + one.key + '"' + did_you_mean(one.key, asked_));
    }
  }
}

void ObjectReader::check_note(const Node& note) {
  const auto is_text = [](const Node& one) { return one.is_text(); };
  const bool good = note.is_null() || note.is_text() || (note.is_array() && std::ranges::all_of(note.array(), is_text));
  if (!good) wrong(note, "a note is a text or an array of texts", errors_);
}

}  // namespace gripline
