// Where plugins keep expensive results from one call to the next: nothing of an experiment's, and never beside it.
#pragma once

#include <filesystem>

namespace gripline {

/// $XDG_CACHE_HOME/gripline, else ~/.cache/gripline (XDG Base Directory Specification: a relative path counts as
/// unset); empty when there is neither: then nothing is kept.
std::filesystem::path plugin_cache_folder();

}  // namespace gripline
