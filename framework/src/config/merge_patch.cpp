#include "config/merge_patch.hpp"

#include <algorithm>
#include <charconv>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/errors.hpp"
#include "config/json_file.hpp"

namespace gripline {
namespace {

void remember(const Node& before, Node& now) {
  const bool same = now.is_text() && before.is_text() && now.text() == before.text();
  if (before.is_text() && !same) now.replaced = std::make_shared<const Node>(before);
}

Node merged(Node base, const Node& patch, bool keep_nulls) {
  if (!patch.is_object()) return patch;
  if (!base.is_object()) {
    base = Node(Node::Object{}, patch.origin);
    base.replaced = patch.replaced;
  }
  if (!base.origin.source) base.origin = patch.origin;  // so that missing members are reported at the patch
  for (const Member& change : patch.object()) {
    const auto known = std::ranges::find(base.object(), change.key, &Member::key);
    const bool absent = known == base.object().end();
    if (change.value.is_null()) {
      if (absent && keep_nulls) base.object().push_back(change);
      if (absent || (keep_nulls && known->value.is_null())) continue;
      if (!known->value.is_null()) base.origin = patch.origin;
      if (keep_nulls) {
        const Node before = std::move(known->value);
        *known = change;
        known->value.replaced = std::make_shared<const Node>(before);
      } else {
        base.object().erase(known);
      }
    } else if (absent) {
      base.object().push_back(change);
      base.object().back().value = merged(Node(), change.value, keep_nulls);
    } else if (known->value.is_object() && change.value.is_object()) {
      known->value = merged(std::move(known->value), change.value, keep_nulls);
    } else {
      const Node before = std::move(known->value);
      *known = change;
      known->value = merged(Node(), change.value, keep_nulls);
      remember(before, known->value);
    }
  }
  return base;
}

bool is_removal(const Member& member) { return member.value.is_null() && member.value.replaced; }

/// Gives every value of a tree the one source, without a line: inside one argument the pointer says enough.
void set_origin(Node& node, const std::shared_ptr<const Source>& source, const std::string& pointer) {
  node.origin = {source, 0, 0, pointer};
  if (node.is_array()) {
    for (std::size_t i = 0; i < node.array().size(); ++i) {
      set_origin(node.array()[i], source, join_pointer(pointer, std::to_string(i)));
    }
  } else if (node.is_object()) {
    for (Member& one : node.object()) {
      one.key_line = one.key_column = 0;
      set_origin(one.value, source, join_pointer(pointer, one.key));
    }
  }
}

/// JSON if it is JSON, else text. What begins like an object, an array or a string is not meant as text.
Node read_value(std::string_view value, const Origin& origin) {
  Node node;
  try {
    node = parse_text(value);
  } catch (const InputError& error) {
    if (!value.empty() && (value.front() == '{' || value.front() == '[' || value.front() == '"')) {
      const Diagnostic& first = error.diagnostics().front();
      throw InputError(origin, "not JSON, column " + std::to_string(first.column) + ": " + first.message);
    }
    node = Node(value);
  }
  set_origin(node, origin.source, origin.pointer);
  return node;
}

/// The element an array's pointer name means: an index, or one past the end for `-`; nothing if it is neither.
std::optional<std::size_t> index_of(const std::string& name, std::size_t size) {
  if (name == "-") return size;
  std::size_t index = 0;
  const char* const end = name.data() + name.size();
  const auto [stop, error] = std::from_chars(name.data(), end, index);
  if (error != std::errc() || stop != end || index >= size) return std::nullopt;
  return index;
}

class Assignment {
 public:
  explicit Assignment(std::string_view pointer)
      : source_(std::make_shared<const Source>(Source{"--set", {}})), pointer_(pointer) {}

  void apply(Node& root, std::string_view value) const {
    const std::vector<std::string> names = [&] {
      try {
        return split_pointer(pointer_);
      } catch (const InputError& error) {
        throw InputError(std::vector{Diagnostic{.file = "--set", .message = error.diagnostics().front().message}});
      }
    }();
    Node* parent = &root;
    std::string path;
    for (std::size_t i = 0; i + 1 < names.size(); ++i) {
      parent = &step(*parent, path, names[i]);
      path = join_pointer(path, names[i]);
    }
    Node node = read_value(value, {source_, 0, 0, std::string(pointer_)});
    if (names.empty()) {
      root = std::move(node);
    } else if (parent->is_array()) {
      Node::Array& elements = parent->array();
      const std::size_t index = element(*parent, path, names.back());
      if (index == elements.size()) elements.emplace_back();
      elements[index] = std::move(node);
    } else if (parent->is_object()) {
      if (const Node* const before = parent->find(names.back()); before != nullptr) remember(*before, node);
      parent->set(names.back(), std::move(node));
    } else {
      refuse(path + " is " + parent->describe() + ", it has no members");
    }
  }

 private:
  [[nodiscard]] std::size_t element(const Node& array, const std::string& path, const std::string& name) const {
    const auto index = index_of(name, array.array().size());
    if (!index) {
      refuse("\"" + name + "\" is not an element of " + path + ", which has " + std::to_string(array.array().size()) +
             "; expected an index from 0, or - for a new one");
    }
    return *index;
  }

  /// The member or element `name` of the value at `path`.
  [[nodiscard]] Node& step(Node& node, const std::string& path, const std::string& name) const {
    const std::string where = path.empty() ? "the top level" : path;
    if (node.is_array()) {
      const std::size_t index = element(node, path, name);
      if (index < node.array().size()) return node.array()[index];
      refuse("- makes a new element and must stand last");
    }
    if (!node.is_object()) refuse(where + " is " + node.describe() + ", it has no members");
    const std::string here = join_pointer(path, name);
    if (Node* const next = node.find(name); next != nullptr) {
      if (!next->is_null()) return *next;
      refuse(here + " is null, which replaces what is inherited; a key below it cannot be set, only the whole: " +
             here + "={...}");
    }
    // Whether such an object is allowed is checked when the tree is read.
    return node.set(name, Node(Node::Object{}, {source_, 0, 0, here}));
  }

  [[noreturn]] void refuse(std::string message) const {
    throw InputError({source_, 0, 0, std::string(pointer_)}, std::move(message));
  }

  std::shared_ptr<const Source> source_;
  std::string_view pointer_;
};

}  // namespace

Node merge(Node base, const Node& patch) { return merged(std::move(base), patch, false); }

Node merge_keeping_nulls(Node base, const Node& patch) { return merged(std::move(base), patch, true); }

void drop_removed(Node& node) {
  if (node.is_array()) {
    for (Node& one : node.array()) drop_removed(one);
  } else if (node.is_object()) {
    std::erase_if(node.object(), is_removal);
    for (Member& one : node.object()) drop_removed(one.value);
  }
}

void set_pointer(Node& root, std::string_view pointer, std::string_view value) {
  Assignment(pointer).apply(root, value);
}

void apply_assignment(Node& root, std::string_view assignment) {
  const auto equals = assignment.find('=');
  if (equals == std::string_view::npos) {
    throw InputError(std::vector{
        Diagnostic{.file = "--set", .pointer = std::string(assignment), .message = "expected /json/pointer=VALUE"}});
  }
  set_pointer(root, assignment.substr(0, equals), assignment.substr(equals + 1));
}

}  // namespace gripline
