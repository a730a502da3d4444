#include "plugin/offered.hpp"

#include <string_view>
#include <vector>

namespace gripline {
namespace {

std::vector<PluginEntry>& offered() {
  static std::vector<PluginEntry> all;
  return all;
}

}  // namespace

void offer_plugin(const PluginEntry& entry) {
  std::erase_if(offered(), [&](const PluginEntry& one) {
    return one.decl->kind == entry.decl->kind && std::string_view(one.decl->id) == entry.decl->id;
  });
  offered().push_back(entry);
}

std::span<const PluginEntry> offered_plugins() { return offered(); }

}  // namespace gripline
