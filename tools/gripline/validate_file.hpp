// One file of any kind, read as the program would read it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/errors.hpp"
#include "plugin/registry.hpp"

namespace gripline::tools {

/// Reads an experiment of any kind, a world, track (JSON or CSV), car, friction schedule or map of a log, and all files
/// that it names, and drives nothing; plants are made, each in a process of its own, to check their grip. Throws
/// InputError with all that is wrong, PluginError when a plugin is missing. Returns warnings of implausible
/// values (world/plausibility.hpp).
std::vector<Diagnostic> validate_file(const std::filesystem::path& file, const Registry& registry);

/// Prints warnings on stderr, one line each: "warning: FILE:3:9: /car/Iz: ..."; `file` is said of those without a place.
void print_warnings(const std::string& file, const std::vector<Diagnostic>& warnings);

}  // namespace gripline::tools
