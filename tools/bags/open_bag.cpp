#include "bags/open_bag.hpp"

#include <array>
#include <fstream>
#include <string_view>

#include "bags/ros1_bag.hpp"
#include "bags/rosbag2.hpp"
#include "config/errors.hpp"
#include "config/files.hpp"

namespace gripline::tools {

std::unique_ptr<bags::BagFile> open_bag(const std::filesystem::path& file) {
  // Readers of bags read a piece at a time.
  if (const std::string why = why_unopenable(file); !why.empty()) throw InputError(shown(file) + ": " + why);
  std::array<char, 16> begin{};
  std::ifstream(file, std::ios::binary).read(begin.data(), begin.size());
  const std::string_view text(begin.data(), begin.size());
  if (text.starts_with("#ROSBAG V")) return open_ros1_bag(file);
  if (text.starts_with(std::string_view("SQLite format 3\0", 16))) return open_rosbag2(file);
  throw InputError(shown(file) +
                   ": neither a ROS 1 bag nor a rosbag2 database (.db3); a .db3.zstd is unpacked first "
                   "(zstd -d), MCAP is not read (ros2 bag convert makes a .db3 of it)");
}

}  // namespace gripline::tools
