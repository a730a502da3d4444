// Folders that a command makes for its results, and takes away again where it ends without any.
#pragma once

#include <filesystem>
#include <system_error>

namespace gripline {

/// Makes a folder and its missing parents, as std::filesystem::create_directories, and remembers those that are new.
void make_folders(const std::filesystem::path& folder, std::error_code& failed);

/// Whether make_folders() made it in this process.
[[nodiscard]] bool made_here(const std::filesystem::path& folder);

/// Removes the folders that make_folders() made in this process and that are empty. For a command that failed.
void remove_empty_made_folders() noexcept;

}  // namespace gripline
