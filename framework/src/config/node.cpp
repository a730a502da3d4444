#include "config/node.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "config/errors.hpp"

namespace gripline {
namespace {

constexpr double two_to_53 = 9007199254740992.0;
constexpr std::size_t longest_shown = 40;

/// A JSON string literal.
std::string string_literal(std::string_view text) {
  constexpr std::string_view hex = "0123456789abcdef";
  std::string result = "\"";
  for (const char c : text) {
    switch (c) {
      case '"':
        result += "\\\"";
        break;
      case '\\':
        result += "\\\\";
        break;
      case '\n':
        result += "\\n";
        break;
      case '\r':
        result += "\\r";
        break;
      case '\t':
        result += "\\t";
        break;
      default:
        if (const auto byte = static_cast<unsigned char>(c); byte < 0x20 || byte == 0x7f) {
          result += "\\u00";
          result += hex[byte >> 4U];
          result += hex[byte & 0xfU];
        } else {
          result += c;
        }
    }
  }
  return result + '"';
}

void write_pretty(const Node& node, const std::string& indent, std::string& out);

/// `[` or `{`, the entries one per line, and the closing bracket.
template <class Range, class Write>
void write_lines(const Range& entries, char open, char close, const std::string& indent, std::string& out,
                 Write write) {
  out += open;
  const char* separator = "\n";
  for (const auto& entry : entries) {
    out += separator + indent + "  ";
    write(entry);
    separator = ",\n";
  }
  if (!entries.empty()) out += "\n" + indent;
  out += close;
}

void write_scalar(const Node& node, std::string& out) {
  if (node.is_boolean()) {
    out += node.boolean() ? "true" : "false";
  } else if (node.is_number()) {
    out += number_text(node.number());
  } else if (node.is_text()) {
    out += string_literal(node.text());
  } else {
    out += "null";
  }
}

void write_pretty(const Node& node, const std::string& indent, std::string& out) {
  if (node.is_array()) {
    write_lines(node.array(), '[', ']', indent, out, [&](const Node& one) { write_pretty(one, indent + "  ", out); });
  } else if (node.is_object()) {
    write_lines(node.object(), '{', '}', indent, out, [&](const Member& one) {
      out += string_literal(one.key) + ": ";
      write_pretty(one.value, indent + "  ", out);
    });
  } else {
    write_scalar(node, out);
  }
}

void write_compact(const Node& node, std::string& out) {
  const char* separator = "";
  if (node.is_array()) {
    out += '[';
    for (const Node& one : node.array()) {
      out += separator;
      write_compact(one, out);
      separator = ",";
    }
    out += ']';
  } else if (node.is_object()) {
    std::vector<const Member*> members;
    for (const Member& one : node.object()) {
      if (one.key != "note" && !one.value.is_null()) members.push_back(&one);
    }
    std::ranges::sort(members, {}, [](const Member* one) { return std::string_view(one->key); });
    out += '{';
    for (const Member* one : members) {
      out += separator + string_literal(one->key) + ':';
      write_compact(one->value, out);
      separator = ",";
    }
    out += '}';
  } else {
    write_scalar(node, out);
  }
}

}  // namespace

Node::Node(Array value, Origin where) : origin(std::move(where)), value_(std::move(value)) {}
Node::Node(Object value, Origin where) : origin(std::move(where)), value_(std::move(value)) {}

Node Node::null(Origin where) {
  Node node;
  node.origin = std::move(where);
  return node;
}

Node number_or_null(double value) { return std::isfinite(value) ? Node(value) : Node::null(); }

Node number_or_null(const std::optional<double>& value) { return value ? number_or_null(*value) : Node::null(); }

const Node* Node::find(std::string_view key) const noexcept {
  const auto* members = std::get_if<Object>(&value_);
  if (members == nullptr) return nullptr;
  const auto it = std::ranges::find(*members, key, &Member::key);
  return it == members->end() ? nullptr : &it->value;
}

Node* Node::find(std::string_view key) noexcept { return const_cast<Node*>(std::as_const(*this).find(key)); }

const Node& Node::at(std::string_view key) const {
  const Node* const member = find(key);
  if (member == nullptr) throw std::out_of_range("there is no \"" + std::string(key) + "\"");
  return *member;
}

Node& Node::set(std::string_view key, Node value) {
  if (is_null()) value_ = Object{};
  if (Node* known = find(key)) return *known = std::move(value);
  const int line = value.origin.line, column = value.origin.column;
  return object().emplace_back(Member{std::string(key), std::move(value), line, column}).value;
}

void Node::erase(std::string_view key) {
  if (is_object()) std::erase_if(object(), [&](const Member& one) { return one.key == key; });
}

std::string Node::describe() const {
  if (is_array()) return array().empty() ? "an empty array" : "an array";
  if (is_object()) return "an object";
  std::string text;
  if (is_text() && this->text().size() > longest_shown) {
    std::size_t cut = longest_shown;
    while (cut > 0 && (static_cast<unsigned char>(this->text()[cut]) & 0xc0U) == 0x80U) --cut;  // whole characters
    return string_literal(this->text().substr(0, cut)) + "...";
  }
  write_scalar(*this, text);
  return text;
}

Origin Member::key_origin() const {
  Origin result = value.origin;
  if (key_line > 0) {
    result.line = key_line;
    result.column = key_column;
  }
  return result;
}

Origin child_of(const Origin& parent, std::string_view name) {
  Origin result = parent;
  result.pointer = join_pointer(parent.pointer, name);
  return result;
}

std::vector<std::string> split_pointer(std::string_view pointer) {
  std::vector<std::string> names;
  if (pointer.empty()) return names;
  if (pointer.front() != '/') {
    throw InputError("\"" + std::string(pointer) + "\" is not a JSON pointer: expected \"/\" and the names from the " +
                     "top, such as \"/world/dt\"");
  }
  for (std::size_t i = 0; i < pointer.size(); ++i) {
    if (pointer[i] == '/') {
      if (names.size() >= static_cast<std::size_t>(max_depth))
        throw InputError("a JSON pointer of more than " + std::to_string(max_depth) + " names");
      names.emplace_back();
    } else if (pointer[i] != '~') {
      names.back() += pointer[i];
    } else if (const char next = i + 1 < pointer.size() ? pointer[i + 1] : '\0'; next == '0' || next == '1') {
      names.back() += next == '0' ? '~' : '/';
      ++i;
    } else {
      throw InputError("\"" + std::string(pointer) + "\" is not a JSON pointer: \"~\" is written \"~0\" in it, and " +
                       "\"/\" within a name \"~1\"");
    }
  }
  return names;
}

std::string join_pointer(std::string_view parent, std::string_view name) {
  std::string result(parent);
  result += '/';
  for (const char c : name) {
    if (c == '~') {
      result += "~0";
    } else if (c == '/') {
      result += "~1";
    } else {
      result += c;
    }
  }
  return result;
}

const Node* find_pointer(const Node& root, std::string_view pointer) {
  const Node* node = &root;
  for (const std::string& name : split_pointer(pointer)) {
    if (node->is_array()) {
      std::size_t index = 0;
      const char* end = name.data() + name.size();
      const auto [stop, error] = std::from_chars(name.data(), end, index);
      if (error != std::errc() || stop != end || index >= node->array().size()) return nullptr;
      node = &node->array()[index];
    } else {
      node = node->find(name);
    }
    if (node == nullptr) return nullptr;
  }
  return node;
}

std::string number_text(double value) {
  if (!std::isfinite(value)) throw std::invalid_argument("JSON has no text for a number that is not finite");
  if (value == 0.0) return std::signbit(value) ? "-0.0" : "0";  // "-0" would be read back as the integer 0
  std::array<char, 32> buffer{};
  char* const end = buffer.data() + buffer.size();
  const bool whole = std::abs(value) < two_to_53 && std::trunc(value) == value;
  const auto result = whole ? std::to_chars(buffer.data(), end, static_cast<long long>(value))
                            : std::to_chars(buffer.data(), end, value);
  return {buffer.data(), result.ptr};
}

std::string to_json_text(const Node& node) {
  std::string out;
  write_pretty(node, "", out);
  return out + '\n';
}

std::string content_text(const Node& node) {
  std::string out;
  write_compact(node, out);
  return out;
}

}  // namespace gripline
