// Files that come with the program (worlds, experiments), found by name from any folder.
#pragma once

#include <filesystem>
#include <string_view>

namespace gripline {

/// What the program stands in as PREFIX/bin/gripline, installed or built: the parent of the running program's folder.
[[nodiscard]] const std::filesystem::path& prefix();

/// The file whose code this is, for the names of runs: the running program, even when its file was replaced meanwhile.
[[nodiscard]] const std::filesystem::path& program_file();

/// For a module that another program loads, such as Python: the module's file, and what it stands in instead.
void set_program(const std::filesystem::path& file, const std::filesystem::path& prefix);

/// PREFIX/share/gripline; empty when there is no such folder.
[[nodiscard]] std::filesystem::path shipped_folder();

/// The file that a user names: itself where it is there; else the shipped one of that name, of that name in the shipped
/// folder `kind` ("experiments"), or of that name with ".json" added; else itself, which is then reported as absent.
[[nodiscard]] std::filesystem::path find_shipped(const std::filesystem::path& named, std::string_view kind);

}  // namespace gripline
