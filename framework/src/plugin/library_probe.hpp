// Whether a file is a usable plugin library. It is read and opened in a process of its own first, so that a broken one
// that crashes or hangs does not end this process.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <gripline/abi.h>

namespace gripline {

/// The name of the manifest's symbol in this ABI.
std::string manifest_symbol_name();

/// Why each of the files cannot be used, in their order; empty where it can. Each is examined as a file first (no
/// pipe, an ELF library, the symbol of this ABI), then opened, and its whole manifest is read.
/// One that does not open within `timeout_s` is given up: the slowest shipped library takes a tenth of a second.
std::vector<std::string> probe_libraries(std::span<const std::filesystem::path> libraries, double timeout_s = 10.0);

/// What is wrong with a manifest that was read from a library of this ABI; empty when nothing is.
std::string manifest_problem(const abi::Manifest& manifest);

/// A warning when every user of this machine may write this file or folder, and so may place code there that runs as
/// its reader; empty when only its owner (and group) may.
std::string open_to_all(const std::filesystem::path& place);

}  // namespace gripline
