#include "plugin/registry.hpp"

#include <dlfcn.h>
#include <algorithm>
#include <boost/dll/library_info.hpp>
#include <boost/dll/runtime_symbol_info.hpp>
#include <boost/dll/shared_library.hpp>
#include <cstdlib>
#include <cstring>
#include <type_traits>

#include <gripline/abi_layout.hpp>

#include "config/errors.hpp"

namespace gripline {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view symbol_stem = "gripline_plugins_abi";
const std::string symbol_name = std::string(symbol_stem) + std::to_string(abi::number);

/// The manifest symbol as the file states it, read without loading the library; empty when there is none.
std::string manifest_symbol(const fs::path& library) {
  boost::dll::library_info info(library, false);
  for (const std::string& symbol : info.symbols())
    if (symbol.rfind(symbol_stem, 0) == 0) return symbol;
  return {};
}

/// Why the dynamic linker refuses a library, in its own words: Boost's message hides them behind an errno of its own.
std::string loader_reason(const fs::path& library) {
  if (void* handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL); handle != nullptr) return "unknown reason";
  const char* text = dlerror();
  return text != nullptr ? text : "unknown reason";
}

/// Whether virtual functions stand in the same places. Compared as bytes: == says nothing of pointers to virtual functions.
bool same_slots(const abi::detail::Chain<>&, const abi::detail::Chain<>&) { return true; }
template <class T, class... Rest>
bool same_slots(const abi::detail::Chain<T, Rest...>& a, const abi::detail::Chain<T, Rest...>& b) {
  if constexpr (std::is_member_pointer_v<T>) {
    if (std::memcmp(&a.first, &b.first, sizeof a.first) != 0) return false;
  } else {
    if (!same_slots(a.first, b.first)) return false;
  }
  return same_slots(a.rest, b.rest);
}

std::string manifest_problem(const abi::Manifest& manifest) {
  const std::string rebuild = "; rebuild the plugin against the installed headers";
  if (manifest.abi != abi::number)
    return "states plugin ABI " + std::to_string(manifest.abi) + ", this gripline has ABI " +
           std::to_string(abi::number) + rebuild;
  if (manifest.size != sizeof(abi::Manifest) || manifest.layout_hash != abi::layout_hash())
    return std::string("its types (built by ") + manifest.compiler + ") differ from this gripline's" + rebuild;
  if (!same_slots(*static_cast<const decltype(abi::virtual_slots)*>(manifest.virtual_slots), abi::virtual_slots))
    return std::string("its virtual functions (built by ") + manifest.compiler +
           ") stand in another order than this gripline's" + rebuild;
  return {};
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
  path.push_back(fs::path(boost::dll::program_location().string()).parent_path().parent_path() / "lib" / "gripline");
  return path;
}

Registry::Registry(std::vector<fs::path> directories) : directories_(std::move(directories)) {
  std::vector<fs::path> searched;
  for (const fs::path& directory : directories_) {
    std::error_code ignored;
    const fs::path real = fs::weakly_canonical(directory, ignored);
    if (std::find(searched.begin(), searched.end(), real) != searched.end()) continue;
    searched.push_back(real);
    std::vector<fs::path> libraries;
    for (const auto& file : fs::directory_iterator(directory, ignored))
      if (file.path().extension() == ".so" && !fs::is_directory(file.path(), ignored)) libraries.push_back(file.path());
    std::sort(libraries.begin(), libraries.end());
    for (const fs::path& library : libraries) load(library);
  }
}

void Registry::load(const fs::path& library) {
  std::string symbol;
  try {
    symbol = manifest_symbol(library);
  } catch (const std::exception&) {
    unusable_.push_back({library, "is not a shared library"});
    return;
  }
  if (symbol.empty()) {
    unusable_.push_back({library, "is not a gripline plugin: it has no symbol " + symbol_name});
    return;
  }
  if (symbol != symbol_name) {
    unusable_.push_back({library, "built for plugin ABI " + symbol.substr(symbol_stem.size()) +
                                      ", this gripline has ABI " + std::to_string(abi::number) +
                                      "; rebuild the plugin against the installed headers"});
    return;
  }
  boost::dll::shared_library handle;
  std::error_code failed;
  handle.load(library, failed, boost::dll::load_mode::rtld_now | boost::dll::load_mode::rtld_local);
  if (failed) {
    unusable_.push_back({library, loader_reason(library)});
    return;
  }
  const auto& manifest = handle.get<const abi::Manifest>(symbol_name);
  handles_.push_back(handle);
  if (const std::string problem = manifest_problem(manifest); !problem.empty())
    unusable_.push_back({library, problem});
  else
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
  for (const fs::path& directory : directories_) text += " " + directory.string();
  for (const Unusable& one : unusable_) text += "; " + one.library.string() + ": " + one.reason;
  throw PluginError(text);
}

}  // namespace gripline
