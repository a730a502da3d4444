// Folders of the user's own, by the XDG Base Directory Specification; a relative path in a variable counts as unset.
#pragma once

#include <filesystem>

namespace gripline {

/// Where plugins keep expensive results between calls, never results of experiments: $XDG_CACHE_HOME/gripline,
/// else ~/.cache/gripline; empty when there is neither: then nothing is kept.
std::filesystem::path plugin_cache_folder();

/// Where users put plugins that every call shall find: $XDG_DATA_HOME/gripline/plugins, else
/// ~/.local/share/gripline/plugins; empty when there is no such folder.
std::filesystem::path user_plugin_folder();

}  // namespace gripline
