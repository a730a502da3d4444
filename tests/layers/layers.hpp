// Which folder of a source tree may include which: the rules stand in the folders' READMEs, and this reads both.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gripline::layers {

/// What is wrong with the components of a tree, one line each; empty where nothing is. A component is a folder that
/// holds C++ files or a README.md.
///  - Every component has a README.md of at most fifteen lines with one sentence `May know: config, util.`, or
///    `nothing`. It names components by their path from the root; knowing `diagnose` is not knowing `diagnose/model`.
///  - A file includes files of its own component and of those that its README names, written from the root in quotes
///    (`"race/stack.hpp"`); what lies outside the tree is included in angle brackets.
///  - No circle, neither of components as the READMEs allow them nor of files as they include each other.
std::vector<std::string> faults(const std::filesystem::path& root);

}  // namespace gripline::layers
