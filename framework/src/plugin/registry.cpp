#include "plugin/registry.hpp"

#include <algorithm>
#include <boost/dll/runtime_symbol_info.hpp>
#include <boost/dll/shared_library.hpp>
#include <cstdlib>
#include <map>

#include "config/errors.hpp"
#include "config/shipped.hpp"
#include "plugin/library_probe.hpp"
#include "plugin/offered.hpp"
#include "plugin/plugin_cache.hpp"
#include "util/process_state.hpp"

namespace gripline {
namespace fs = std::filesystem;

namespace {

bool is_library(const fs::directory_entry& entry) {
  std::error_code ignored;
  return entry.path().extension() == ".so" && !entry.is_directory(ignored);
}

bool has_library(const fs::path& folder) {
  std::error_code ignored;
  const fs::directory_iterator files(folder, ignored);
  return std::any_of(begin(files), end(files), is_library);
}

/// Where the libraries of a folder without one most likely are, in brackets; empty where none is one level below.
std::string libraries_below(const fs::path& folder) {
  std::error_code ignored;
  std::vector<fs::path> below;
  if (has_library(folder)) return {};
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (entry.is_directory(ignored) && has_library(entry.path())) below.push_back(entry.path());
  if (below.empty()) return {};
  return " (without a plugin; one is in " + std::min_element(below.begin(), below.end())->string() + ")";
}

}  // namespace

std::string_view kind_name(abi::Kind kind) {
  constexpr std::string_view names[] = {"vehicle", "effect", "estimator", "planner", "controller", "plant"};
  return names[static_cast<std::size_t>(kind)];
}

std::vector<fs::path> Registry::search_path(std::span<const std::string> extra_directories) {
  std::vector<fs::path> path(extra_directories.begin(), extra_directories.end());
  if (const char* variable = std::getenv("GRIPLINE_PLUGIN_PATH"); variable != nullptr) {
    std::string_view rest = variable;
    while (!rest.empty()) {
      const std::size_t colon = rest.find(':');
      if (colon != 0) path.emplace_back(std::string(rest.substr(0, colon)));
      if (colon == std::string_view::npos) break;
      rest.remove_prefix(colon + 1);
    }
  }
  if (const fs::path own = user_plugin_folder(); !own.empty()) path.push_back(own);
  path.push_back(prefix() / "lib" / "gripline");
  return path;
}

Registry::Registry(std::vector<fs::path> directories)
    : directories_(std::move(directories)), entries_(offered_plugins().begin(), offered_plugins().end()) {
  std::vector<fs::path> searched, libraries;
  for (const fs::path& directory : directories_) {
    std::error_code ignored;
    const fs::path real = fs::weakly_canonical(directory, ignored);
    if (std::find(searched.begin(), searched.end(), real) != searched.end()) continue;
    searched.push_back(real);
    std::vector<fs::path> found;
    for (const auto& file : fs::directory_iterator(directory, ignored))
      if (file.path().extension() == ".so" && !fs::is_directory(file.path(), ignored)) found.push_back(file.path());
    std::sort(found.begin(), found.end());
    if (found.empty()) continue;
    if (std::string warning = open_to_all(directory); !warning.empty()) warnings_.push_back(std::move(warning));
    for (const fs::path& library : found)
      if (std::string warning = open_to_all(library); !warning.empty()) warnings_.push_back(std::move(warning));
    libraries.insert(libraries.end(), found.begin(), found.end());
  }
  const std::vector<std::string> problems = probe_libraries(libraries);
  for (std::size_t i = 0; i < libraries.size(); ++i) {
    if (problems[i].empty())
      load(libraries[i]);
    else
      unusable_.push_back({libraries[i], problems[i]});
  }
}

/// Opens a library that probe_libraries() found usable.
void Registry::load(const fs::path& library) {
  const ProcessState state;
  boost::dll::shared_library handle;
  std::error_code failed;
  handle.load(library, failed, boost::dll::load_mode::rtld_now | boost::dll::load_mode::rtld_local);
  if (failed) {
    unusable_.push_back({library, "cannot be opened: " + failed.message()});
    return;
  }
  const auto& manifest = handle.get<const abi::Manifest>(manifest_symbol_name());
  handles_.push_back(handle);
  add(library, manifest);
}

void Registry::add(const fs::path& library, const abi::Manifest& manifest) {
  for (const abi::PluginDecl& decl : std::span(manifest.plugins, manifest.plugin_count)) {
    const auto same = std::find_if(entries_.begin(), entries_.end(), [&](const PluginEntry& entry) {
      return entry.decl->kind == decl.kind && std::string_view(entry.decl->id) == decl.id;
    });
    if (same != entries_.end())
      throw PluginError(std::string(kind_name(decl.kind)) + " \"" + decl.id + "\" is offered twice: by " +
                        same->library.string() + " and by " + library.string());
    entries_.push_back({&decl, library});
  }
}

const PluginEntry& Registry::find(abi::Kind kind, std::string_view id) const {
  std::vector<std::string> known;
  for (const PluginEntry& entry : entries_) {
    if (entry.decl->kind != kind) continue;
    if (id == entry.decl->id) return entry;
    known.emplace_back(entry.decl->id);
  }
  std::string text = "no " + std::string(kind_name(kind)) + " plugin \"" + std::string(id) + "\"";
  for (const PluginEntry& entry : entries_)
    if (id == entry.decl->id)
      text += "; \"" + std::string(id) + "\" is of kind " + std::string(kind_name(entry.decl->kind));
  text += did_you_mean(id, known);
  text += "; searched";
  for (const fs::path& directory : directories_) text += " " + directory.string() + libraries_below(directory);
  // A folder that was built for another gripline has one reason for all its libraries.
  std::map<std::string, std::vector<const Registry::Unusable*>> reasons;
  for (const Registry::Unusable& one : unusable_) reasons[one.reason].push_back(&one);
  for (const auto& [reason, libraries] : reasons) {
    text += "; " + libraries.front()->library.string();
    if (libraries.size() > 1) text += " and " + std::to_string(libraries.size() - 1) + " more";
    text += ": " + reason;
  }
  throw PluginError(text);
}

}  // namespace gripline
