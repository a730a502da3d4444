// The equation of a plugin, as far as somebody wrote it down: for `gripline plugins describe`.
#pragma once

#include <string>

#include "plugin/registry.hpp"

namespace gripline::tools {

/// Lines that are the equation: those that the plugin's library states (gripline/equation.hpp), else those of the pages
/// effects.md and models.md. Empty where there are none.
std::string equation_of(const PluginEntry& entry);

}  // namespace gripline::tools
