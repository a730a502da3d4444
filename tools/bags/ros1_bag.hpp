// Bags of ROS 1, format 2.0 (http://wiki.ros.org/Bags/Format/2.0). No library reads them here: that of ROS trusts every
// length and position in the file.
#pragma once

#include <filesystem>
#include <memory>

#include "bags/bag_file.hpp"

namespace gripline::tools {

/// Throws InputError: another version, no index (a recording that was not ended), encrypted, records beyond the file.
std::unique_ptr<bags::BagFile> open_ros1_bag(const std::filesystem::path& file);

}  // namespace gripline::tools
