#include "plugin/library_probe.hpp"

#include <dlfcn.h>
#include <sys/stat.h>

#include <algorithm>
#include <boost/dll/library_info.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>
#include <type_traits>

#include <gripline/abi_layout.hpp>

#include "config/errors.hpp"
#include "config/units.hpp"
#include "plugin/registry.hpp"
#include "util/child_process.hpp"

namespace gripline {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view symbol_stem = "gripline_plugins_abi";

/// The manifest symbol as the file states it, read without loading the library; empty when there is none.
std::string symbol_in(const fs::path& library) {
  boost::dll::library_info info(library, false);
  for (const std::string& symbol : info.symbols())
    if (symbol.rfind(symbol_stem, 0) == 0) return symbol;
  return {};
}

/// Why a file must not be opened; empty if it may.
std::string file_problem(const fs::path& library) {
  std::error_code failed;
  const fs::file_status status = fs::status(library, failed);
  if (!fs::is_regular_file(status))
    return fs::exists(status) ? "is not a file: a pipe, a device or a folder" : "cannot be read: " + failed.message();
  std::string symbol;
  try {
    symbol = symbol_in(library);
  } catch (const std::exception&) {
    return "is not a shared library";
  }
  // A stripped library (packages strip theirs) lists no symbols here, but the loader finds them.
  if (symbol.empty() || symbol == manifest_symbol_name()) return {};
  return "built for plugin ABI " + escape_control(symbol.substr(symbol_stem.size())) + ", this gripline has ABI " +
         std::to_string(abi::number) + "; rebuild the plugin against the installed headers";
}

/// Opens the library as the registry will: "" or what is wrong. Runs in the child only.
std::string opened_problem(const fs::path& library) {
  void* const handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    const char* const text = dlerror();
    return text != nullptr ? escape_control(text) : "unknown reason";
  }
  const auto* const manifest = static_cast<const abi::Manifest*>(dlsym(handle, manifest_symbol_name().c_str()));
  return manifest == nullptr
             ? "is not a gripline plugin: it has no symbol " + manifest_symbol_name() +
                   R"(; write GRIPLINE_PLUGINS(gripline::describe<Class>("id", "1.0", "what it is")) in its source)"
             : manifest_problem(*manifest);
}

/// Whether virtual functions are in the same slots. Compared as bytes, because == of pointers to virtual functions is
/// unspecified.
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

bool is_plain(const char* text) { return text != nullptr && *text != '\0' && escape_control(text) == text; }

/// What is wrong with one declared parameter.
std::string param_problem(const abi::ParamDecl& p) {
  if (!is_plain(p.name)) return "a parameter without a plain name";
  const std::string name = "the parameter \"" + std::string(p.name) + "\"";
  if (p.unit == nullptr || p.doc == nullptr) return name + " without a unit or a description";
  if (p.type > abi::ParamType::table) return name + " of an unknown type";
  if (p.type == abi::ParamType::choice && p.choices == nullptr) return name + " that is a choice without options";
  if (!(p.lo <= p.hi) || std::isnan(p.default_value)) return name + " with an invalid range or default";
  // Such numbers become ints, here and in the plugin. Whoever builds with the SDK's headers is told by the compiler.
  const auto is_int = [](double value) {
    return value >= std::numeric_limits<int>::min() && value <= std::numeric_limits<int>::max();
  };
  const bool whole = p.type == abi::ParamType::integer || p.type == abi::ParamType::choice;
  if (whole && !(is_int(p.lo) && is_int(p.hi) && is_int(p.default_value)))
    return name + ", whose range or default is beyond what an int holds";
  try {
    (void)Unit::parse(p.unit);
  } catch (const UnitError& error) {
    return name + " with an invalid unit: " + error.what();
  }
  return {};
}

std::string decl_problem(const abi::PluginDecl& decl) {
  if (decl.kind > abi::Kind::plant) return "declares a plugin of an unknown kind";
  if (!is_plain(decl.id))
    return "declares a plugin whose id is " +
           (decl.id == nullptr || *decl.id == '\0' ? "empty" : "not plain text: \"" + escape_control(decl.id) + "\"");
  const std::string who = std::string(kind_name(decl.kind)) + " \"" + decl.id + "\" is declared with ";
  if (decl.version == nullptr || decl.summary == nullptr || decl.advice == nullptr)
    return who + "no version, no summary or no advice";
  if (decl.create == nullptr || decl.destroy == nullptr) return who + "no constructor or no destructor";
  if (decl.params == nullptr && decl.param_count > 0) return who + "a null parameter array";
  for (const abi::ParamDecl& param : std::span(decl.params, decl.param_count))
    if (const std::string problem = param_problem(param); !problem.empty()) return who + problem;
  return {};
}

}  // namespace

std::string manifest_symbol_name() { return std::string(symbol_stem) + std::to_string(abi::number); }

std::string manifest_problem(const abi::Manifest& manifest) {
  const std::string rebuild = "; rebuild the plugin against the installed headers";
  if (manifest.abi != abi::number)
    return "states plugin ABI " + std::to_string(manifest.abi) + ", this gripline has ABI " +
           std::to_string(abi::number) + rebuild;
  const std::string builder = escape_control(manifest.compiler != nullptr ? manifest.compiler : "an unknown compiler");
  if (manifest.size != sizeof(abi::Manifest) || manifest.layout_hash != abi::layout_hash())
    return "its types (built by " + builder + ") differ from this gripline's" + rebuild;
  if (manifest.virtual_slots == nullptr ||
      !same_slots(*static_cast<const decltype(abi::virtual_slots)*>(manifest.virtual_slots), abi::virtual_slots))
    return "its virtual functions (built by " + builder + ") stand in another order than this gripline's" + rebuild;
  if (manifest.plugins == nullptr && manifest.plugin_count > 0) return "its plugin array is null";
  for (const abi::PluginDecl& decl : std::span(manifest.plugins, manifest.plugin_count))
    if (const std::string problem = decl_problem(decl); !problem.empty()) return problem;
  return {};
}

std::vector<std::string> probe_libraries(std::span<const fs::path> libraries, double timeout_s) {
  std::vector<std::string> problems(libraries.size());
  std::size_t next = 0;
  // One child looks at all of them; if it dies at one, the next child continues with the one after that.
  while (next < libraries.size()) {
    const ChildResult result = run_in_child(timeout_s, [&](const SendMessage& send) {
      for (const fs::path& library : libraries.subspan(next)) {
        std::string problem = file_problem(library);
        if (problem.empty()) problem = opened_problem(library);
        send(problem);
      }
    });
    for (const std::string& problem : result.messages) problems[next++] = problem;
    if (result.completed || next >= libraries.size()) break;
    problems[next++] = "cannot be opened: the process that tried " + result.failure;
  }
  return problems;
}

std::string open_to_all(const fs::path& place) {
  struct stat found {};
  if (stat(place.c_str(), &found) != 0 || (found.st_mode & S_IWOTH) == 0) return {};
  return place.string() +
         " can be written by everybody on this machine: a plugin that another user puts there runs as you";
}

}  // namespace gripline
