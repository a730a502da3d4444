#pragma once
#include <concepts>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace gripline {

/// Arrays and objects within each other, at most: trees are walked by recursion.
inline constexpr int max_depth = 200;

/// Where text came from: a file, or an argument of the command line.
struct Source {
  std::string name;              ///< as shown to the user: "worlds/ethz.json", "--set"
  std::filesystem::path folder;  ///< relative paths inside the text start here; empty is the working folder
};

/// Where a value is written. Survives merging: a value keeps the file, line and pointer it was first read at.
struct Origin {
  std::shared_ptr<const Source> source;  ///< null for values made by the program
  int line = 0;                          ///< from 1; 0 is unknown
  int column = 0;                        ///< from 1, in characters
  std::string pointer;                   ///< JSON pointer (RFC 6901) within that source; empty is the whole
};

/// Origin of the member or element `name` of the value at `parent`, for messages about one that is missing there.
[[nodiscard]] Origin child_of(const Origin& parent, std::string_view name);

struct Member;

/// A JSON value that knows where it was written. A plain value type: copies are deep. Numbers are doubles, so integers
/// are exact up to 2^53. Nesting is limited by the parser, so recursion over a tree is safe.
class Node {
 public:
  using Array = std::vector<Node>;
  using Object = std::vector<Member>;  ///< in the order written; keys are unique

  Node();
  template <std::same_as<bool> B>
  explicit Node(B value, Origin where = {});
  template <class N>
  requires(std::is_arithmetic_v<N> && !std::same_as<N, bool>) explicit Node(N value, Origin where = {});
  explicit Node(std::string_view value, Origin where = {});
  explicit Node(const char* value, Origin where = {});
  explicit Node(Array value, Origin where = {});
  explicit Node(Object value, Origin where = {});
  [[nodiscard]] static Node null(Origin where = {});
  [[nodiscard]] static Node empty_object();

  [[nodiscard]] bool is_null() const noexcept { return std::holds_alternative<std::monostate>(value_); }
  [[nodiscard]] bool is_boolean() const noexcept { return std::holds_alternative<bool>(value_); }
  [[nodiscard]] bool is_number() const noexcept { return std::holds_alternative<double>(value_); }
  [[nodiscard]] bool is_text() const noexcept { return std::holds_alternative<std::string>(value_); }
  [[nodiscard]] bool is_array() const noexcept { return std::holds_alternative<Array>(value_); }
  [[nodiscard]] bool is_object() const noexcept { return std::holds_alternative<Object>(value_); }

  /// The value as what it is; std::bad_variant_access if it is something else.
  [[nodiscard]] bool boolean() const { return std::get<bool>(value_); }
  [[nodiscard]] double number() const { return std::get<double>(value_); }
  [[nodiscard]] const std::string& text() const { return std::get<std::string>(value_); }
  [[nodiscard]] const Array& array() const { return std::get<Array>(value_); }
  [[nodiscard]] Array& array() { return std::get<Array>(value_); }
  [[nodiscard]] const Object& object() const { return std::get<Object>(value_); }
  [[nodiscard]] Object& object() { return std::get<Object>(value_); }

  /// The member `key`, or null if there is none or this is not an object. The pointer lives until the object changes.
  [[nodiscard]] const Node* find(std::string_view key) const noexcept;
  [[nodiscard]] Node* find(std::string_view key) noexcept;
  /// The member `key`; std::out_of_range where find() gives null. For files of our own, which may have been damaged.
  [[nodiscard]] const Node& at(std::string_view key) const;
  /// Replaces the member `key`, or adds it last. A null node becomes an object. Gives back the member's value.
  Node& set(std::string_view key, Node value);
  /// Removes the member `key` if it is there.
  void erase(std::string_view key);

  /// What was found, for messages: `null`, `true`, `3`, `"text"`, `an array`, `an object`.
  [[nodiscard]] std::string describe() const;

  Origin origin;
  /// The text that a merge put this in the place of; null if there was none. A text may name a file or a plugin: what
  /// is missing here, or too much beside it, may follow from that. Of a null, whatever it was put in the place of: a
  /// null without it removes nothing.
  std::shared_ptr<const Node> replaced;

 private:
  std::variant<std::monostate, bool, double, std::string, Array, Object> value_;
};

/// A member of an object. The key's place is its own: an unknown key is reported at the key, a bad value at the value.
struct Member {
  std::string key;
  Node value;
  int key_line = 0;
  int key_column = 0;

  /// Where the key is written, with the pointer of the value.
  [[nodiscard]] Origin key_origin() const;
};

// Here, where Member is complete.
inline Node::Node() = default;
inline Node Node::empty_object() { return Node(Object{}); }
template <std::same_as<bool> B>
Node::Node(B value, Origin where) : origin(std::move(where)), value_(value) {}
template <class N>
requires(std::is_arithmetic_v<N> && !std::same_as<N, bool>) Node::Node(N value, Origin where)
    : origin(std::move(where)), value_(static_cast<double>(value)) {}
inline Node::Node(std::string_view value, Origin where) : origin(std::move(where)), value_(std::string(value)) {}
inline Node::Node(const char* value, Origin where) : Node(std::string_view(value), std::move(where)) {}

/// Splits a JSON pointer into its names (`~1` is `/`, `~0` is `~`). Throws InputError unless it is empty or starts
/// with `/`, every `~` is followed by 0 or 1 and it has at most max_depth names.
[[nodiscard]] std::vector<std::string> split_pointer(std::string_view pointer);
/// `parent/name` with `name` escaped.
[[nodiscard]] std::string join_pointer(std::string_view parent, std::string_view name);
/// The value at a pointer, or null. It is part of `root`, which therefore may not be a temporary.
[[nodiscard]] const Node* find_pointer(const Node& root, std::string_view pointer);
const Node* find_pointer(const Node&& root, std::string_view pointer) = delete;

/// Shortest text that reads back as the same double, and is a JSON number; whole numbers below 2^53 without a
/// fraction or an exponent. Throws std::invalid_argument if it is not finite.
[[nodiscard]] std::string number_text(double value);

/// The number, or null for one that is not finite, which JSON does not have, or that there is not.
[[nodiscard]] Node number_or_null(double value);
[[nodiscard]] Node number_or_null(const std::optional<double>& value);

/// The tree as JSON: members in their order, two spaces of indentation, a newline at the end. The same tree always
/// gives the same bytes, in any locale, and parse_text() reads them back as the same tree.
[[nodiscard]] std::string to_json_text(const Node& node);

/// One line of JSON for content keys: members sorted, no blanks, members called "note" and null members left out.
[[nodiscard]] std::string content_text(const Node& node);

}  // namespace gripline
