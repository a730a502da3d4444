#include "config/json_file.hpp"

#include <algorithm>
#include <memory>
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

  /// `patch` over the file that `name` names.
  Node merged_over(const Node& name, const Node& patch, int depth) {
    if (!name.is_text())
      throw InputError(name.origin, "expected the path of a JSON file to extend, found " + name.describe());
    const fs::path file = resolve_path(name);
    if (const std::string reason = why_unreadable(file); !reason.empty()) {
      throw InputError(name.origin, '"' + name.text() + "\": " + reason);
    }
    refuse_circle(name, file);
    if (chain_.size() >= static_cast<std::size_t>(json_limits.chain))
      throw InputError(name.origin, "files extend files more than " + std::to_string(json_limits.chain) + " deep");
    if (++opened_ > json_limits.files)
      throw InputError(name.origin,
                       "\"extends\" opens more than " + std::to_string(json_limits.files) + " files: each use counts");
    Node base = load(file, depth);
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
  const fs::path file = resolve_path(node);
  if (const std::string reason = why_unreadable(file); !reason.empty()) {
    throw InputError(node.origin, '"' + node.text() + "\": " + reason);
  }
  node = load_json(file);
}

fs::path resolve_path(const Node& text) {
  const fs::path path(text.text());
  const fs::path folder = text.origin.source ? text.origin.source->folder : fs::path();
  const fs::path file = (folder / path).lexically_normal();
  std::error_code failed;
  if (path.is_absolute() || path.empty() || fs::exists(file, failed) || shipped_folder().empty()) return file;
  const fs::path shipped = (shipped_folder() / path).lexically_normal();
  return fs::is_regular_file(shipped, failed) ? shipped : file;
}

}  // namespace gripline
