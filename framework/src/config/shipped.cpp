#include "config/shipped.hpp"

#include <string>

namespace gripline {
namespace fs = std::filesystem;

const fs::path& prefix() {
  static const fs::path place = [] {
    std::error_code failed;
    return fs::read_symlink("/proc/self/exe", failed).parent_path().parent_path();
  }();
  return place;
}

fs::path shipped_folder() {
  std::error_code failed;
  const fs::path folder = prefix() / "share" / "gripline";
  return fs::is_directory(folder, failed) ? folder : fs::path();
}

fs::path find_shipped(const fs::path& named, std::string_view kind) {
  std::error_code failed;
  if (named.empty() || named.is_absolute() || shipped_folder().empty() || fs::exists(named, failed)) return named;
  const fs::path in_kind = shipped_folder() / kind / named;
  for (const fs::path& candidate : {shipped_folder() / named, in_kind, fs::path(in_kind.string() + ".json")})
    if (fs::is_regular_file(candidate, failed)) return candidate.lexically_normal();
  return named;
}

}  // namespace gripline
