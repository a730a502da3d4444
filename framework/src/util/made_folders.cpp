#include "util/made_folders.hpp"

#include <algorithm>
#include <vector>

namespace gripline {
namespace {

namespace fs = std::filesystem;

/// In the order in which they were made: parents first. Absolute, as a command may change the working folder.
std::vector<fs::path>& made_folders() {
  static std::vector<fs::path> folders;
  return folders;
}

/// Without a slash at the end, so that every parent is another folder.
fs::path plain_path(const fs::path& folder, std::error_code& failed) {
  const fs::path path = fs::absolute(folder, failed).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

}  // namespace

void make_folders(const fs::path& folder, std::error_code& failed) {
  std::vector<fs::path> missing;
  std::error_code ignored;
  for (fs::path path = plain_path(folder, ignored); path.has_relative_path() && !fs::exists(path, ignored);
       path = path.parent_path())
    missing.push_back(path);
  fs::create_directories(folder, failed);
  for (auto path = missing.rbegin(); path != missing.rend(); ++path)
    if (fs::is_directory(*path, ignored)) made_folders().push_back(*path);
}

bool made_here(const fs::path& folder) {
  std::error_code ignored;
  return std::ranges::find(made_folders(), plain_path(folder, ignored)) != made_folders().end();
}

void remove_empty_made_folders() noexcept {
  std::error_code ignored;
  for (auto path = made_folders().rbegin(); path != made_folders().rend(); ++path)
    if (fs::is_directory(*path, ignored)) fs::remove(*path, ignored);  // only an empty one
  made_folders().clear();
}

}  // namespace gripline
