// The import of logs by a program that reads bags of ROS, and by one that does not.
#pragma once

#include <filesystem>
#include <memory>

#include "bags/bag_file.hpp"
#include "cli/program.hpp"

namespace gripline::tools {

using OpenBag = std::unique_ptr<bags::BagFile> (*)(const std::filesystem::path& file);

/// The command `import`. Without `open` bags are left to the program gripline-bags, which replaces this one.
int import_log(Arguments args, OpenBag open);

}  // namespace gripline::tools
