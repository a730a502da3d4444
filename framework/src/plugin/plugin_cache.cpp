#include "plugin/plugin_cache.hpp"

#include <cstdlib>

namespace gripline {

namespace fs = std::filesystem;
namespace {

/// The folder that a variable names, else one below the home folder; empty when there is neither.
fs::path user_folder(const char* variable, const char* below_home) {
  const auto absolute = [](const char* name) -> fs::path {
    const char* const text = std::getenv(name);
    const fs::path path = text != nullptr ? text : "";
    return path.is_absolute() ? path : fs::path();
  };
  if (const fs::path base = absolute(variable); !base.empty()) return base;
  if (const fs::path home = absolute("HOME"); !home.empty()) return home / below_home;
  return {};
}

}  // namespace

fs::path plugin_cache_folder() {
  const fs::path base = user_folder("XDG_CACHE_HOME", ".cache");
  return base.empty() ? base : base / "gripline";
}

fs::path user_plugin_folder() {
  const fs::path folder = user_folder("XDG_DATA_HOME", ".local/share") / "gripline" / "plugins";
  std::error_code failed;
  return folder.is_absolute() && fs::is_directory(folder, failed) ? folder : fs::path();
}

}  // namespace gripline
