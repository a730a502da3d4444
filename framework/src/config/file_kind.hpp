// Kind of a JSON file, known by keys that only this kind has: a file of the wrong kind is refused with one message.
#pragma once

#include <string_view>

#include "config/node.hpp"

namespace gripline {

enum class FileKind { experiment, world, track, car, friction, log_map, unknown };

[[nodiscard]] FileKind kind_of(const Node& tree);
/// "an experiment", "a world", ...
[[nodiscard]] std::string_view kind_text(FileKind kind);
/// Throws InputError ("is a world, expected an experiment") when the tree is certainly of another kind.
void expect_kind(const Node& tree, FileKind expected);

/// Puts the file that a text node names in its place (inline_file); the wrong kind is refused where it is named.
void inline_file_of(Node& node, FileKind expected);

}  // namespace gripline
