// One file of any kind, read as the program would read it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "plugin/registry.hpp"

namespace gripline::tools {

/// Reads an experiment of any kind, a world, track (JSON or CSV), car, friction schedule or map of a log, and all files
/// that it names, and drives nothing; plants are made, each in a process of its own, to check their grip. Throws
/// InputError with all that is wrong, PluginError when a plugin is missing. Returns warnings of implausible
/// values, one line each (world/plausibility.hpp).
std::vector<std::string> validate_file(const std::filesystem::path& file, const Registry& registry);

/// Prints warnings of implausible values in a file on stderr, one line each: "warning: FILE: ...".
void print_warnings(const std::string& file, const std::vector<std::string>& warnings);

}  // namespace gripline::tools
