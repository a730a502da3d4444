#pragma once
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/errors.hpp"
#include "config/node.hpp"

namespace gripline {

/// The numbers allowed, SI. An open end is excluded.
struct NumberRange {
  double lo = -std::numeric_limits<double>::infinity();
  double hi = std::numeric_limits<double>::infinity();
  bool lo_open = false;
  bool hi_open = false;

  [[nodiscard]] static constexpr NumberRange any() { return {}; }
  [[nodiscard]] static constexpr NumberRange closed(double lo, double hi) { return {lo, hi, false, false}; }
  [[nodiscard]] static constexpr NumberRange positive() { return at_most(std::numeric_limits<double>::infinity()); }
  /// ]0, hi]
  [[nodiscard]] static constexpr NumberRange at_most(double hi) { return {0.0, hi, true, false}; }
  [[nodiscard]] static constexpr NumberRange non_negative() {
    return {0.0, std::numeric_limits<double>::infinity(), false, false};
  }
  [[nodiscard]] constexpr bool contains(double v) const {
    return (lo_open ? v > lo : v >= lo) && (hi_open ? v < hi : v <= hi);
  }
  /// A number to carry on with after an error: inside the range.
  [[nodiscard]] double some() const;
};

/// Whole numbers from lo to hi, both allowed.
struct IntegerRange {
  std::int64_t lo = std::numeric_limits<std::int64_t>::min();
  std::int64_t hi = std::numeric_limits<std::int64_t>::max();
};

/// Reads of one value. Each adds to `errors` what is wrong and then gives back a valid value of the right kind.
/// A JSON number is SI; text is a number with a unit (to_si).
[[nodiscard]] double read_number(const Node& node, std::string_view unit, const NumberRange& range, Errors& errors);
[[nodiscard]] std::int64_t read_integer(const Node& node, const IntegerRange& range, Errors& errors);
[[nodiscard]] bool read_boolean(const Node& node, Errors& errors);
[[nodiscard]] std::string read_text(const Node& node, Errors& errors);
/// The place of the text among `names`, 0 after an error.
[[nodiscard]] std::size_t read_choice(const Node& node, std::span<const std::string> names, Errors& errors);
/// The elements; none after an error.
[[nodiscard]] std::span<const Node> read_array(const Node& node, Errors& errors);
/// An array of `count` numbers of one unit (any number of them if `count` is empty).
[[nodiscard]] std::vector<double> read_numbers(const Node& node, std::string_view unit, const NumberRange& range,
                                               std::optional<std::size_t> count, Errors& errors);

/// A cursor over one JSON object that knows which keys were asked for. Every reading function takes the key; without a
/// fallback the key must be there. A null member counts as absent ("null removes"). finish() reports every key nobody
/// asked for; "note" (text, or an array of texts) is allowed in every object. Nothing here throws for bad input: errors
/// are collected, and the values read are to be used only if there were none.
/// Node and Errors must outlive the reader.
class ObjectReader {
 public:
  ObjectReader(const Node& node, Errors& errors);
  ObjectReader(const ObjectReader&) = delete;
  ObjectReader& operator=(const ObjectReader&) = delete;
  /// Calls finish(), for readers that live only inside an expression or a block.
  ~ObjectReader();

  /// SI; a fallback is given in SI as well and is not checked against the range.
  double number(std::string_view key, std::string_view unit, const NumberRange& range = {},
                std::optional<double> fallback = std::nullopt);
  std::optional<double> optional_number(std::string_view key, std::string_view unit, const NumberRange& range = {});
  std::int64_t integer(std::string_view key, const IntegerRange& range = {},
                       std::optional<std::int64_t> fallback = std::nullopt);
  bool boolean(std::string_view key, std::optional<bool> fallback = std::nullopt);
  std::string text(std::string_view key, const std::optional<std::string>& fallback = std::nullopt);
  /// One of `names`.
  std::string choice(std::string_view key, std::span<const std::string> names,
                     const std::optional<std::string>& fallback = std::nullopt);
  /// One of an enumeration's names.
  template <class E>
  E choice(std::string_view key, std::initializer_list<std::pair<const char*, E>> names,
           std::optional<E> fallback = std::nullopt);
  /// A path, relative to the file that holds the value; not checked for existence.
  std::filesystem::path path(std::string_view key);
  /// A path to a file that can be read; a missing one is an error with the nearest name in its folder.
  std::filesystem::path input_file(std::string_view key);
  /// The same, of a file whose name has one of these endings (why_no_input()).
  std::filesystem::path input_file(std::string_view key, std::span<const std::string_view> endings);
  /// The elements of an array; none if the key is absent and `required` is false.
  std::span<const Node> array(std::string_view key, bool required = true);
  std::vector<double> numbers(std::string_view key, std::string_view unit, const NumberRange& range = {},
                              std::optional<std::size_t> count = std::nullopt);
  /// The object under the key, to be read further. If it is missing, that is reported once; the reader returned then
  /// gives valid defaults and reports nothing more.
  ObjectReader object(std::string_view key);

  /// The value of a key that may be absent (null pointer then); marks the key as asked for.
  const Node* find(std::string_view key);
  /// The value of a key that must be there; null after the error.
  const Node* require(std::string_view key, std::string_view expected);
  /// Whether a key is there; marks it as asked for, since one that may be absent is known all the same.
  [[nodiscard]] bool has(std::string_view key);
  /// All members but "note" and nulls, all marked as asked for: for objects whose keys are names the user chose.
  std::vector<const Member*> members();

  /// Reports every key that was not asked for, with the nearest that was. Further calls do nothing.
  void finish();

  [[nodiscard]] const Node& node() const { return node_; }
  [[nodiscard]] Errors& errors() { return errors_; }
  /// Adds an error at this object.
  void error(std::string message) { errors_.add(node_.origin, std::move(message)); }
  /// Whether this object lacks keys of a file whose name it took the place of in a merge. That is reported in one
  /// message: to be merged over a file, an object says "extends".
  [[nodiscard]] bool lacks_replaced_file() const { return lacks_replaced_file_; }
  /// Adds an error at the value of `key`, or at this object if it is absent.
  void error_at(std::string_view key, std::string message);

 private:
  ObjectReader(const Node& node, Errors& errors, bool missing);
  void asked(std::string_view key);
  [[nodiscard]] std::optional<std::filesystem::path> replaced_file() const;
  void tell_missing(std::string_view key, std::string_view expected);
  void check_note(const Node& note);

  const Node& node_;
  Errors& errors_;
  std::vector<std::string> asked_;
  bool silent_;  ///< there is no object: that was reported, its keys are not
  bool finished_ = false;
  bool lacks_replaced_file_ = false;
};

template <class E>
E ObjectReader::choice(std::string_view key, std::initializer_list<std::pair<const char*, E>> names,
                       std::optional<E> fallback) {
  std::vector<std::string> texts;
  for (const auto& [name, value] : names) texts.emplace_back(name);
  if (fallback && find(key) == nullptr) return *fallback;
  const Node* node = require(key, "a choice");
  return names.begin()[node != nullptr ? read_choice(*node, texts, errors_) : 0].second;
}

}  // namespace gripline
