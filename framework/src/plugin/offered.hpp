// Plugins of a program that uses gripline as a library, such as classes of Python: there is no library file to find.
#pragma once

#include <span>

#include "plugin/registry.hpp"

namespace gripline {

/// Every registry made from now on has this plugin. It replaces one of the same kind and id that was offered before.
/// `entry.library` is the file that defines it, whose hash is part of run_key(). The declaration must outlive all.
void offer_plugin(const PluginEntry& entry);
std::span<const PluginEntry> offered_plugins();

}  // namespace gripline
