#include "config/file_kind.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "config/errors.hpp"
#include "config/json_file.hpp"

namespace gripline {
namespace {

std::string mismatch(FileKind found, FileKind expected) {
  if (found == expected || found == FileKind::unknown) return {};
  return "is " + std::string(kind_text(found)) + ", expected " + std::string(kind_text(expected));
}

bool has_any(const Node& tree, std::initializer_list<const char*> keys) {
  return std::any_of(keys.begin(), keys.end(), [&](const char* key) {
    const Node* const member = tree.find(key);
    return member != nullptr && !member->is_null();
  });
}

}  // namespace

FileKind kind_of(const Node& tree) {
  if (has_any(tree, {"kind", "stacks", "world"})) return FileKind::experiment;
  if (has_any(tree, {"plant"})) return FileKind::world;
  if (has_any(tree, {"segments", "centre", "edges"})) return FileKind::track;
  if (has_any(tree, {"lf"})) return FileKind::car;
  if (has_any(tree, {"points", "per_step", "patches"})) return FileKind::friction;
  if (has_any(tree, {"channels"})) return FileKind::log_map;
  return FileKind::unknown;
}

std::string_view kind_text(FileKind kind) {
  constexpr std::array<std::string_view, 7> texts = {"an experiment",
                                                     "a world",
                                                     "a track",
                                                     "a car",
                                                     "a friction schedule",
                                                     "a map of a log",
                                                     "a file of an unknown kind"};
  return texts[static_cast<std::size_t>(kind)];
}

void expect_kind(const Node& tree, FileKind expected) {
  const std::string problem = mismatch(kind_of(tree), expected);
  if (problem.empty()) return;
  Origin whole = tree.origin;
  whole.line = whole.column = 0;
  throw InputError(whole, problem);
}

void inline_file_of(Node& node, FileKind expected) {
  if (!node.is_text()) return;
  const Node name = node;
  inline_file(node);
  const std::string problem = mismatch(kind_of(node), expected);
  if (!problem.empty()) throw InputError(name.origin, name.describe() + " " + problem);
}

}  // namespace gripline
