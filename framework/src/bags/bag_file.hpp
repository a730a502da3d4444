// What a reader of a container of messages offers: topics with their types, and messages about in the order of
// recording (a ROS 1 bag: chunk by chunk).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "bags/message_schema.hpp"

namespace gripline::bags {

struct Topic {
  std::string name;        // begins with '/'
  std::string type;        // "nav_msgs/Odometry" or "nav_msgs/msg/Odometry"
  std::string definition;  // as parse_schema() takes it; "" where the file holds none
  std::size_t messages = 0;
};

struct Message {
  std::size_t topic = 0;      // index
  std::int64_t recorded = 0;  // when the recorder got it [ns], from 0 to latest_time
  std::span<const std::byte> bytes;
};

inline constexpr std::int64_t latest_time = std::int64_t{1} << 62U;  // [ns] since 1970: year 2116

/// Everything throws InputError, which names the file.
class BagFile {
 public:
  BagFile() = default;
  BagFile(const BagFile&) = delete;
  BagFile& operator=(const BagFile&) = delete;
  virtual ~BagFile() = default;

  virtual const std::filesystem::path& file() const = 0;
  virtual Wire wire() const = 0;
  virtual const std::vector<Topic>& topics() const = 0;
  /// When the first message of all was recorded [ns].
  virtual std::int64_t start() const = 0;
  /// Hands the messages of the topics that are `wanted` to `take`, until it returns false.
  virtual void read(const std::vector<bool>& wanted, const std::function<bool(const Message&)>& take) = 0;
};

}  // namespace gripline::bags
