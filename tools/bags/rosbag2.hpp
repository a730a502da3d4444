// Recordings of ROS 2 in SQLite (rosbag2's storage plugin sqlite3): one .db3 file of a recording.
#pragma once

#include <filesystem>
#include <memory>

#include "bags/bag_file.hpp"

namespace gripline::tools {

/// Throws InputError: another database, another serialization than CDR, gripline built without SQLite.
std::unique_ptr<bags::BagFile> open_rosbag2(const std::filesystem::path& file);

}  // namespace gripline::tools
