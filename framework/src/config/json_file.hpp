#pragma once
#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "config/node.hpp"

namespace gripline {

/// Strict JSON (RFC 8259, UTF-8; a UTF-8 byte order mark is skipped). Refused with one InputError that says where:
/// syntax errors, comments, a truncated text, not UTF-8, NaN and Infinity, numbers beyond a double, a key written twice
/// in one object, nesting deeper than max_depth, and what only a mistake or an attack holds: JsonLimits.

/// What one call of parse_text() or load_json() may read, so that no file takes all memory or time. An experiment of
/// a thousand stacks stays far below.
struct JsonLimits {
  std::size_t bytes = std::size_t{64} << 20U;      ///< of one text or file
  std::size_t key = 1000;                          ///< bytes of one key
  std::size_t name = 4096;                         ///< bytes of a file's name, with the pointer behind it
  std::size_t members = 10'000;                    ///< of one object
  std::size_t values = 1'000'000;                  ///< of all files together, every repetition by "extends" counted
  std::size_t pointers = std::size_t{128} << 20U;  ///< bytes of the places of all values together
  int files = 1000;                                ///< opened by "extends"
  int chain = 32;                                  ///< files that extend files
};
inline constexpr JsonLimits json_limits;

/// The text alone: "extends" is an ordinary key here. `name` is shown in messages, relative paths start from `folder`.
[[nodiscard]] Node parse_text(std::string_view text, std::string name = "text", std::filesystem::path folder = {});

/// A file alone. Also refused: a missing file (with the nearest name in its folder), a folder,
/// an empty or unreadable file.
[[nodiscard]] Node parse_file(const std::filesystem::path& file);

/// A file with every "extends" carried out: an object that says `"extends": "other.json"` (relative to its file) is
/// that file's object with this one's members merged over it, at any depth. `"other.json#/stacks/best"` extends the
/// object at that JSON pointer (RFC 6901) of the file, every "extends" in it carried out; a file's name may hold a '#'
/// and ends at the first "#/" before which there is a file. Files that extend each other in a circle, whichever part,
/// are refused with the chain, and so is what grows beyond json_limits. In such a merge a null takes the place
/// of an inherited member and stays, so that a stack's `"estimator": null` also removes the estimator of the "base"
/// that the stack is merged over (merge_keeping_nulls).
[[nodiscard]] Node load_json(const std::filesystem::path& file);

/// Replaces a text node, which names a JSON file relative to the file it is written in, by that file's tree
/// (load_json). Other nodes stay as they are. Errors of naming are reported at the node.
void inline_file(Node& node);

/// Endings of files that other files name.
inline constexpr std::array<std::string_view, 2> input_endings = {".json", ".csv"};
inline constexpr std::span<const std::string_view> json_ending = std::span(input_endings).first(1);
inline constexpr std::span<const std::string_view> csv_ending = std::span(input_endings).last(1);

/// The file a text node names, relative to where the node is written. Not checked for existence.
[[nodiscard]] std::filesystem::path resolve_path(const Node& text);

/// Why the file that a text node names cannot be read as an input, as the second half of a sentence about it; empty if
/// it can. Its name must have one of the endings: by them the files of an experiment are found when runs are told apart
/// by what they read, and a change of any other file would go unnoticed. A node of no source was named by an argument
/// of the command line alone, such as --track, which may be a pipe.
[[nodiscard]] std::string why_no_input(const Node& text, std::span<const std::string_view> endings);

}  // namespace gripline
