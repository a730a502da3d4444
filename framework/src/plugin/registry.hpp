// Finds, checks, loads and instantiates plugins.
//
// A library is refused before any of its code is loaded when its symbol table names another ABI, and opened in a
// process of its own before it is opened here (library_probe.hpp). The registry holds every library it loaded; it must
// outlive all instances.
#pragma once

#include <boost/dll/shared_library.hpp>
#include <filesystem>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <gripline/abi.h>

#include "plugin/guard.hpp"
#include "util/process_state.hpp"

namespace gripline {

/// A plugin that cannot be found, loaded or created: exit code 3.
class PluginError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// "vehicle", "effect", ...: the kind's name in messages.
std::string_view kind_name(abi::Kind kind);

/// A loaded library's plugin.
struct PluginEntry {
  const abi::PluginDecl* decl = nullptr;
  std::filesystem::path library;
  std::span<const abi::ParamDecl> params() const { return {decl->params, decl->param_count}; }
  bool needs_truth() const { return (decl->flags & abi::needs_truth) != 0; }
};

class Registry {
 public:
  /// Searches the directories in this order, each once and not recursive, *.so sorted by name, links followed. A
  /// library that cannot be used is remembered with its reason; two libraries that offer one id are an error.
  explicit Registry(std::vector<std::filesystem::path> directories);

  /// --plugins DIR..., then GRIPLINE_PLUGIN_PATH, then the user's own folder (~/.local/share/gripline/plugins, or
  /// $XDG_DATA_HOME/gripline/plugins), then ../lib/gripline as seen from the program.
  static std::vector<std::filesystem::path> search_path(std::span<const std::string> extra_directories);

  /// Throws PluginError that names the nearest id, the searched directories and every library that could not be used.
  const PluginEntry& find(abi::Kind kind, std::string_view id) const;

  std::span<const PluginEntry> entries() const { return entries_; }
  struct Unusable {
    std::filesystem::path library;
    std::string reason;
  };
  std::span<const Unusable> unusable() const { return unusable_; }
  /// What the user should know although it stops nothing: folders that everybody may write to.
  std::span<const std::string> warnings() const { return warnings_; }

 private:
  void load(const std::filesystem::path& library);
  void add(const std::filesystem::path& library, const abi::Manifest& manifest);

  std::vector<std::filesystem::path> directories_;
  std::vector<boost::dll::shared_library> handles_;
  std::vector<PluginEntry> entries_;
  std::vector<Unusable> unusable_;
  std::vector<std::string> warnings_;
};

/// Destroys an instance by its library, and notes that call: a destructor may end the process.
class Destroyer {
 public:
  Destroyer(const abi::PluginDecl* decl = nullptr) : decl_(decl) {}  // NOLINT(google-explicit-constructor)
  void operator()(void* instance) const {
    if (LastCall* const call = last_call(); call != nullptr) call->note(decl_->id, LastCall::Phase::being_destroyed);
    decl_->destroy(instance);
  }

 private:
  const abi::PluginDecl* decl_;
};

/// An owned instance of a plugin's interface.
template <class Interface>
using Instance = std::unique_ptr<Interface, Destroyer>;

/// Creates an instance; throws PluginError with the plugin's own words when its constructor fails.
template <class Interface>
Instance<Interface> create(const PluginEntry& entry, const PluginContext& context,
                           std::span<const abi::ParamValue> values) {
  const ProcessState state;  // a constructor may change the folder, the locale, what signals do
  if (LastCall* const call = last_call(); call != nullptr) call->note(entry.decl->id, LastCall::Phase::being_made);
  char error[1024] = "";
  void* const raw = entry.decl->create(&context, values.data(), error, sizeof error);
  if (raw == nullptr) throw PluginError(std::string(entry.decl->id) + ": " + error);
  if (LastCall* const call = last_call(); call != nullptr) call->note(entry.decl->id, LastCall::Phase::made);
  return {static_cast<Interface*>(raw), entry.decl};
}

}  // namespace gripline
