#include "plugin/plugin_cache.hpp"

#include <cstdlib>

namespace gripline {

std::filesystem::path plugin_cache_folder() {
  const auto absolute = [](const char* name) -> std::filesystem::path {
    const char* const text = std::getenv(name);
    const std::filesystem::path path = text != nullptr ? text : "";
    return path.is_absolute() ? path : std::filesystem::path();
  };
  if (const std::filesystem::path base = absolute("XDG_CACHE_HOME"); !base.empty()) return base / "gripline";
  if (const std::filesystem::path home = absolute("HOME"); !home.empty()) return home / ".cache" / "gripline";
  return {};
}

}  // namespace gripline
