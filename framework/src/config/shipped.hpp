// Files that come with the program (worlds, experiments), found by name from any folder.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace gripline {

/// PREFIX of the running program PREFIX/bin/gripline, installed or built: the parent of its folder.
[[nodiscard]] const std::filesystem::path& prefix();

/// The file of the running program, whose hash is part of every run_key(); readable even if it was replaced since.
[[nodiscard]] const std::filesystem::path& program_file();

/// For a module loaded by another program, such as Python: sets program_file() and prefix() to the module's.
void set_program(const std::filesystem::path& file, const std::filesystem::path& prefix);

/// PREFIX/share/gripline; empty when there is no such folder.
[[nodiscard]] std::filesystem::path shipped_folder();

/// The file that a user names: itself where it is there; else the shipped one of that name, of that name in the shipped
/// folder `kind` ("experiments"; by default in any of them), or of that name with ".json" added. Else, where nothing of
/// nearly that name stands in the user's folder but something shipped is called nearly so, throws InputError that names
/// it; else itself, which is then reported as absent.
[[nodiscard]] std::filesystem::path find_shipped(const std::filesystem::path& named, std::string_view kind = {});

/// Why the file that JSON names cannot be read, as why_unreadable(). Where nothing of nearly that name stands beside
/// the user's file, with the nearest shipped one, as JSON names it: "experiments/first_race.json".
[[nodiscard]] std::string why_unreadable_as(std::string_view named, const std::filesystem::path& file);

/// How a file that stands in `folder` names `file`: as a shipped one where it is one.
[[nodiscard]] std::string name_from(const std::filesystem::path& file, const std::filesystem::path& folder);

}  // namespace gripline
