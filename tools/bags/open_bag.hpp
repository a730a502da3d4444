// Which reader a bag needs.
#pragma once

#include <filesystem>
#include <memory>

#include "bags/bag_file.hpp"

namespace gripline::tools {

/// A ROS 1 bag or a rosbag2 database, by its first bytes. Throws InputError.
std::unique_ptr<bags::BagFile> open_bag(const std::filesystem::path& file);

}  // namespace gripline::tools
