// Whether a file is a library of plugins that can be used: found out in a process of its own, so that what a broken one
// does when it is read or opened costs that file only.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <gripline/abi.h>

namespace gripline {

/// The manifest's symbol in this ABI, and the part of it that every ABI shares.
std::string manifest_symbol_name();

/// Why each of the files cannot be used, in their order; empty where it can. Each is looked at as a file first (no
/// pipe, an ELF library, the symbol of this ABI), then opened, and all that its manifest says is read.
/// One that does not open within `patience_s` is given up: the slowest of ours takes a tenth of a second.
std::vector<std::string> probe_libraries(std::span<const std::filesystem::path> libraries, double patience_s = 10.0);

/// What is wrong with a manifest that was read from a library of this ABI; empty when nothing is.
std::string manifest_problem(const abi::Manifest& manifest);

/// A warning when every user of this machine may write this file or folder, and so may place code there that runs as
/// its reader; empty when only its owner (and group) may.
std::string open_to_all(const std::filesystem::path& place);

}  // namespace gripline
