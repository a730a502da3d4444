// Messages of ROS as bytes, written here and not by what reads them; a bag in memory; a weaving car's topics.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bags/bag_file.hpp"

namespace gripline::testing_support {

/// Writes fields one after the other: as ROS 1 does, or as CDR of either order of bytes.
class MessageBytes {
 public:
  explicit MessageBytes(bags::Wire wire, bool big_endian = false, unsigned id = 0) : wire_(wire), big_(big_endian) {
    if (wire == bags::Wire::cdr) bytes_ = {std::byte{0}, static_cast<std::byte>(id + (big_ ? 0 : 1)), {}, {}};
  }
  template <class T>
  MessageBytes& add(T value) {
    while (wire_ == bags::Wire::cdr && (bytes_.size() - 4) % sizeof(T) != 0) bytes_.push_back(std::byte{0xEE});
    auto raw = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
    if (big_) std::reverse(raw.begin(), raw.end());
    bytes_.insert(bytes_.end(), raw.begin(), raw.end());
    return *this;
  }
  MessageBytes& text(const std::string& words) {
    const bool zero = wire_ == bags::Wire::cdr;
    add(static_cast<std::uint32_t>(words.size() + (zero ? 1 : 0)));
    for (const char c : words) bytes_.push_back(static_cast<std::byte>(c));
    if (zero) bytes_.push_back(std::byte{0});
    return *this;
  }
  MessageBytes& numbers(const std::vector<double>& values) {
    for (const double v : values) add(v);
    return *this;
  }
  MessageBytes& header(std::int64_t stamp) {
    if (wire_ == bags::Wire::ros1) add(std::uint32_t{7});
    add(static_cast<std::uint32_t>(stamp / 1'000'000'000)).add(static_cast<std::uint32_t>(stamp % 1'000'000'000));
    return text("base");
  }
  const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
  bags::Wire wire_;
  bool big_;
  std::vector<std::byte> bytes_;
};

struct Recorded {
  std::size_t topic = 0;
  std::int64_t time = 0;  // [ns]
  std::vector<std::byte> bytes;
};

/// What a recorder heard, by time.
struct Recording {
  bags::Wire wire = bags::Wire::ros1;
  std::vector<bags::Topic> topics;
  std::vector<Recorded> messages;

  std::size_t topic(const std::string& name, const std::string& type, const std::string& definition) {
    topics.push_back({name, type, definition, 0});
    return topics.size() - 1;
  }
  void add(std::size_t topic, std::int64_t time, std::vector<std::byte> bytes) {
    ++topics[topic].messages;
    messages.push_back({topic, time, std::move(bytes)});
  }
  void sort() {
    std::stable_sort(messages.begin(), messages.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  }
};

class MemoryBag : public bags::BagFile {
 public:
  explicit MemoryBag(Recording all) : all_(std::move(all)) { all_.sort(); }
  const std::filesystem::path& file() const override { return file_; }
  bags::Wire wire() const override { return all_.wire; }
  const std::vector<bags::Topic>& topics() const override { return all_.topics; }
  std::int64_t start() const override { return all_.messages.front().time; }
  void read(const std::vector<bool>& wanted, const std::function<bool(const bags::Message&)>& take) override {
    for (const Recorded& m : all_.messages)
      if (wanted[m.topic] && !take({m.topic, m.time, m.bytes})) return;
  }

 private:
  std::filesystem::path file_ = "drive.bag";
  Recording all_;
};

inline constexpr const char* header_text = "uint32 seq\ntime stamp\nstring frame_id\n";
inline constexpr const char* rule =
    "================================================================================\n";

/// Definitions as ROS 1 puts them into a bag.
inline std::string odometry_text() {
  const std::string r = rule;
  return "# an estimate of a position and velocity\nHeader header\nstring "
         "child_frame_id\ngeometry_msgs/PoseWithCovariance "
         "pose\ngeometry_msgs/TwistWithCovariance twist\n\n" +
         r + "MSG: std_msgs/Header\n" + header_text + "\n" + r +
         "MSG: geometry_msgs/PoseWithCovariance\nPose pose\n# row-major\nfloat64[36] covariance\n\n" + r +
         "MSG: geometry_msgs/Pose\nPoint position\nQuaternion orientation\n\n" + r +
         "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n\n" + r +
         "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n\n" + r +
         "MSG: geometry_msgs/TwistWithCovariance\nTwist twist\nfloat64[36] covariance\n\n" + r +
         "MSG: geometry_msgs/Twist\nVector3 linear\nVector3 angular\n\n" + r +
         "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
}
inline std::string ackermann_text() {
  return std::string("Header header\nAckermannDrive drive\n") + rule + "MSG: std_msgs/Header\n" + header_text + rule +
         "MSG: ackermann_msgs/AckermannDrive\nfloat32 steering_angle\nfloat32 steering_angle_velocity\nfloat32 "
         "speed\nfloat32 acceleration\nfloat32 jerk\n";
}

/// A car that weaves at 10 m/s: its motion at a time [s], in closed form but for the place.
struct Weaving {
  static double rate(double t) { return 0.6 * std::sin(0.8 * t); }
  static double yaw(double t) { return 3.0 + 0.75 * (1.0 - std::cos(0.8 * t)); }  // passes pi
  static double steer(double t) { return std::atan(2.6 * rate(t) / 10.0); }
  static double throttle(double t) { return 0.2 + 0.05 * std::sin(0.3 * t); }
};
inline constexpr std::int64_t weaving_start = 1'700'000'000'250'000'000;  // [ns]

/// Odometry at 20 Hz, recorded 4 ms after its stamp, steering at 25 Hz, a throttle without a header at 10 Hz.
inline Recording weaving_recording(bags::Wire wire, double seconds = 40.0, bool definitions = true) {
  const bool ros1 = wire == bags::Wire::ros1;
  const std::string middle = ros1 ? "/" : "/msg/";
  Recording all;
  all.wire = wire;
  const auto odom = all.topic("/odom", "nav_msgs" + middle + "Odometry", definitions && ros1 ? odometry_text() : "");
  const auto drive = all.topic("/vesc/drive", "ackermann_msgs" + middle + "AckermannDriveStamped",
                               definitions && ros1 ? ackermann_text() : "");
  const auto throttle = all.topic("/throttle", "std_msgs" + middle + "Float64", definitions ? "float64 data\n" : "");
  const auto at = [](double t) { return weaving_start + std::llround(1e9 * t); };
  double x = 5, y = -2;
  for (int k = 0; k <= std::lround(seconds / 0.05); ++k) {
    const double t = 0.05 * k, yaw = Weaving::yaw(t);
    MessageBytes m(wire);
    m.header(at(t)).text("car").numbers({x, y, 0, 0, 0, std::sin(yaw / 2), std::cos(yaw / 2)});
    m.numbers(std::vector<double>(36, 0.01)).numbers({10, 0, 0, 0, 0, Weaving::rate(t)});
    all.add(odom, at(t + 0.004), m.numbers(std::vector<double>(36, 0.02)).bytes());
    const double middle_yaw = Weaving::yaw(t + 0.025);
    x += 0.5 * std::cos(middle_yaw), y += 0.5 * std::sin(middle_yaw);
  }
  for (int k = 0; k <= std::lround(seconds / 0.04); ++k) {
    const double t = 0.04 * k;
    MessageBytes m(wire);
    m.header(at(t)).add(static_cast<float>(Weaving::steer(t))).add(0.0f).add(10.0f).add(0.0f).add(0.0f);
    all.add(drive, at(t + 0.001), m.bytes());
  }
  for (int k = 0; k <= std::lround(seconds / 0.1); ++k)
    all.add(throttle, at(0.1 * k), MessageBytes(wire).add(Weaving::throttle(0.1 * k)).bytes());
  all.sort();
  return all;
}

inline const char* weaving_map() {
  return R"({"time": "time", "channels": {
    "x": {"column": "/odom.pose.pose.position.x"}, "y": {"column": "/odom.pose.pose.position.y"},
    "yaw": {"column": "/odom.pose.pose.orientation.yaw"}, "vx": {"column": "/odom.twist.twist.linear.x"},
    "yaw_rate": {"column": "/odom.twist.twist.angular.z"},
    "d": {"column": "/throttle.data", "kind": "command"},
    "delta": {"column": "/vesc/drive.drive.steering_angle", "kind": "command"}},
    "bag": {"rows": "/odom"}})";
}

}  // namespace gripline::testing_support
