// What a message of a ROS type holds, read from the text that defines the type: http://wiki.ros.org/msg and, for ROS 2,
// https://design.ros2.org/articles/legacy_interface_definition.html
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace gripline::bags {

/// How messages are written: ROS 1 without padding, little endian; ROS 2 as CDR, aligned, of either order of bytes.
enum class Wire { ros1, cdr };

enum class Kind {
  boolean,
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float32,
  float64,
  time,      // two 32 bit numbers: seconds and nanoseconds
  duration,  // two 32 bit numbers, as time
  text,
  wide_text,
  message
};
/// Bytes of a number, of each half of a time; 0 of texts and messages.
std::size_t size_of(Kind kind);
/// A number, or a time, which counts as seconds.
bool is_number(Kind kind);

struct Field {
  enum class Many { one, fixed, variable };
  std::string name;
  Kind kind = Kind::uint8;
  std::size_t type = 0;  // of a message: its index in the schema
  Many many = Many::one;
  std::uint64_t count = 1;  // of a fixed array
};

struct MessageType {
  std::string name;  // "geometry_msgs/Pose"
  std::vector<Field> fields;
  std::uint64_t least_bytes = 0;  // of one message, without padding
};

/// A type and all that it is made of; the first is the type itself.
struct Schema {
  std::vector<MessageType> types;
  Wire wire = Wire::ros1;
  const MessageType& root() const { return types.front(); }
};

/// Texts of definitions by type, "geometry_msgs/Pose".
using Definitions = std::map<std::string, std::string>;

/// The type's name without ROS 2's "msg": "geometry_msgs/Pose" for "geometry_msgs/msg/Pose".
std::string short_type(std::string_view type);

/// Reads the definition of `type`. `text`: its own, behind a line of "====" and "MSG: pkg/Type" those of the types it
/// is made of; what is not there is taken from `others`. Throws InputError: a type that nobody defines, a line that is
/// no field, a type that holds itself.
Schema parse_schema(const std::string& type, const std::string& text, Wire wire, const Definitions& others);

/// Definitions of common messages, for ROS 2 recordings that hold none: std_msgs, geometry_msgs, nav_msgs/Odometry,
/// sensor_msgs/Imu, NavSatFix and JointState, ackermann_msgs.
const Definitions& common_definitions();
/// The definitions in a folder: PACKAGE/msg/TYPE.msg or PACKAGE/TYPE.msg, at any depth. Throws InputError where there
/// are none.
Definitions definitions_in(const std::filesystem::path& folder);

/// Paths of the numbers that every message of the type has, "pose.position.x"; elements of fixed arrays up to
/// `longest_array`; no more than `most`.
std::vector<std::string> number_paths(const Schema& schema, std::uint64_t longest_array, std::size_t most);

}  // namespace gripline::bags
