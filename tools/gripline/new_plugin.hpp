// A plugin to start from: gripline plugins new KIND NAME.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace gripline::tools {

/// A file of tools/templates, compiled in (cmake/EmbedTemplates.cmake).
struct Template {
  std::string_view name;  ///< "estimator.cpp"
  std::string_view text;
};
std::span<const Template> templates();

/// Writes a plugin, its CMakeLists.txt and an experiment to try it in into a new folder `folder`. Throws
/// InputError when the kind is unknown, the name is not an identifier in lower case, or the folder is there.
void write_new_plugin(const std::string& kind, const std::string& name, const std::filesystem::path& folder);

}  // namespace gripline::tools
