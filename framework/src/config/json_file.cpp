#include "config/json_file.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/errors.hpp"
#include "config/files.hpp"
#include "config/json_parser.hpp"
#include "config/merge_patch.hpp"
#include "config/shipped.hpp"

namespace gripline {
namespace {

namespace fs = std::filesystem;

Node parse(const fs::path& file, JsonBudget& budget) {
  return parse_json(read_bytes(file), std::make_shared<const Source>(Source{shown(file), file.parent_path()}), budget);
}

/// `file`, as `name` names it, if it can be read.
fs::path readable(const Node& name, const fs::path& file, std::string_view text) {
  if (const std::string reason = why_unreadable_as(text, file); !reason.empty())
    throw InputError(name.origin, '"' + std::string(text) + "\": " + reason);
  return file;
}

void refuse_long(const Node& name) {
  if (name.text().size() > json_limits.name)
    throw InputError(name.origin, "a file's name of " + std::to_string(name.text().size()) +
                                      " bytes; the longest that is read has " + std::to_string(json_limits.name));
}

/// What "extends" names: a file, and a JSON pointer to the part of it.
struct Extended {
  fs::path file;
  std::string pointer;  ///< empty is the whole
};

bool is_file(const fs::path& file) {
  std::error_code failed;
  return fs::exists(file, failed) && !fs::is_directory(file, failed);
}

/// The file before a '#' with no pointer behind it, which is the whole (RFC 6901, 6); nothing where there is no such
/// file.
std::optional<Extended> whole_before_sign(const Node& name) {
  const std::string_view text = name.text();
  for (std::size_t end = text.find('#'); end != std::string_view::npos; end = text.find('#', end + 1)) {
    const std::string_view before = text.substr(0, end);
    const fs::path file = resolve_path(Node(before, name.origin));
    if (!is_file(file)) continue;
    if (end + 1 == text.size()) return Extended{readable(name, file, before), {}};
    throw InputError(name.origin, "no such file: " + name.describe() + "; a part of \"" + std::string(before) +
                                      "\" is named by a JSON pointer, which begins with \"#/\"");
  }
  return std::nullopt;
}

/// A file's name may hold a '#' too: it ends at the first "#/" before which there is a file.
Extended extended_by(const Node& name) {
  refuse_long(name);
  const std::string_view text = name.text();
  const std::size_t first = text.find("#/");
  if (first == 0) throw InputError(name.origin, "expected the name of a file before the \"#\" of " + name.describe());
  std::error_code failed;
  for (std::size_t end = first; end != std::string_view::npos; end = text.find("#/", end + 1)) {
    const fs::path file = resolve_path(Node(text.substr(0, end), name.origin));
    if (is_file(file)) return {readable(name, file, text.substr(0, end)), std::string(text.substr(end + 1))};
  }
  const fs::path whole = resolve_path(name);
  if (!fs::exists(whole, failed))
    if (auto other = whole_before_sign(name)) return *std::move(other);
  // Without such a folder the name before the first "#/" is the one that was misspelt.
  if (first == std::string_view::npos || fs::is_directory(whole.parent_path(), failed))
    return {readable(name, whole, text), {}};
  const std::string_view before = text.substr(0, first);
  return {readable(name, resolve_path(Node(before, name.origin)), before), std::string(text.substr(first + 1))};
}

/// The names that could follow `node`, and what is wrong with `name` there.
std::string no_such_part(const Node& node, const std::string& name) {
  if (node.is_array())
    return ": \"" + name + "\" is not one of its " + std::to_string(node.array().size()) + " elements, counted from 0";
  if (!node.is_object()) return ": it is " + node.describe();
  std::vector<std::string> keys;
  for (const Member& one : node.object()) keys.push_back(one.key);
  return ": no \"" + name + "\" there" + did_you_mean(name, keys);
}

/// The value at `pointer` of what `name` extends.
Node part_of(const Node& root, const std::string& pointer, const Node& name) {
  const std::vector<std::string> keys = [&] {
    try {
      return split_pointer(pointer);
    } catch (const InputError& error) {
      throw InputError(name.origin, error.diagnostics().front().message);
    }
  }();
  const Node* node = &root;
  std::string above;
  for (const std::string& key : keys) {
    const Node* const next = find_pointer(*node, join_pointer("", key));
    if (next == nullptr) {
      throw InputError(name.origin, "there is no value at " + pointer + " of \"" + root.origin.source->name + "\", " +
                                        (above.empty() ? "the top level" : above) + no_such_part(*node, key));
    }
    node = next;
    above = join_pointer(above, key);
  }
  return *node;
}

/// Loads files that extend files. Knows the chain it is in, to notice a circle.
class Loader {
 public:
  /// `depth`: of the place that the file is loaded for.
  Node load(const fs::path& file, int depth = 0) {
    Node node = parse(file, budget_);
    chain_.push_back(file);
    expand(node, depth);
    chain_.pop_back();
    return node;
  }

 private:
  void expand(Node& node, int depth) {
    if (depth > max_depth)
      throw InputError(node.origin,
                       "with what it extends, nested deeper than " + std::to_string(max_depth) + " levels");
    if (node.is_array()) {
      for (Node& one : node.array()) expand(one, depth + 1);
    } else if (node.is_object()) {
      for (Member& one : node.object()) expand(one.value, depth + 1);
      if (const Node* base = node.find("extends")) {
        const Node name = *base;
        node.erase("extends");
        if (!name.is_null()) node = merged_over(name, node, depth);
      }
    }
  }

  /// `patch` over the file, or the part of one, that `name` names.
  Node merged_over(const Node& name, const Node& patch, int depth) {
    if (!name.is_text())
      throw InputError(name.origin, "expected the path of a JSON file to extend, found " + name.describe());
    const auto [file, pointer] = extended_by(name);
    refuse_circle(name, file);
    if (chain_.size() >= static_cast<std::size_t>(json_limits.chain))
      throw InputError(name.origin, "files extend files more than " + std::to_string(json_limits.chain) + " deep");
    if (++opened_ > json_limits.files)
      throw InputError(name.origin,
                       "\"extends\" opens more than " + std::to_string(json_limits.files) + " files: each use counts");
    Node base = load(file, depth);
    if (!pointer.empty()) base = part_of(base, pointer, name);
    if (!base.is_object()) {
      throw InputError(name.origin,
                       '"' + name.text() + "\" holds " + base.describe() + ", expected an object to extend");
    }
    base.erase("note");  // it describes the other file
    Node merged = merge_keeping_nulls(std::move(base), patch);
    merged.origin = patch.origin;
    return merged;
  }

  void refuse_circle(const Node& name, const fs::path& file) const {
    const auto same = [&](const fs::path& other) {
      std::error_code error;
      return fs::equivalent(other, file, error);
    };
    const auto first = std::ranges::find_if(chain_, same);
    if (first == chain_.end()) return;
    std::string circle;
    for (auto it = first; it != chain_.end(); ++it) circle += shown(*it) + " -> ";
    throw InputError(name.origin, "files extend each other in a circle: " + circle + shown(*first));
  }

  std::vector<fs::path> chain_;
  JsonBudget budget_;
  int opened_ = 0;
};

}  // namespace

Node parse_text(std::string_view text, std::string name, fs::path folder) {
  JsonBudget budget;
  return parse_json(text, std::make_shared<const Source>(Source{std::move(name), std::move(folder)}), budget);
}

Node parse_file(const fs::path& file) {
  JsonBudget budget;
  return parse(file, budget);
}

Node load_json(const fs::path& file) { return Loader().load(file); }

void inline_file(Node& node) {
  if (!node.is_text()) return;
  refuse_long(node);
  node = load_json(readable(node, resolve_path(node), node.text()));
}

std::string why_no_input(const Node& text, std::span<const std::string_view> endings) {
  std::string why = why_unreadable_as(text.text(), resolve_path(text));
  const auto has = [&](std::string_view ending) { return text.text().ends_with(ending); };
  if (!why.empty() || text.origin.source == nullptr || std::ranges::any_of(endings, has)) return why;
  for (const std::string_view ending : endings) why += (why.empty() ? "" : " or ") + std::string(ending);
  return "expected a file whose name ends in " + why;
}

fs::path resolve_path(const Node& text) {
  const fs::path path(text.text());
  const fs::path folder = text.origin.source ? text.origin.source->folder : fs::path();
  fs::path file = without_dots(folder / path);
  std::error_code failed;
  if (path.is_absolute() || path.empty() || fs::exists(file, failed) || shipped_folder().empty()) return file;
  const fs::path shipped = (shipped_folder() / path).lexically_normal();
  return fs::is_regular_file(shipped, failed) ? shipped : file;
}

}  // namespace gripline
