#include "bags/bag_guess.hpp"

#include <algorithm>
#include <array>
#include <set>

#include "bags/bag_table.hpp"
#include "config/errors.hpp"
#include "tables/column_names.hpp"

namespace gripline::bags {
namespace {

constexpr std::size_t most_numbers = 30'000'000;  // read for a guess: 240 MB
constexpr std::size_t most_paths = 300;           // looked at of one type

/// What a member of a common type is, in a word that guesses know.
struct Member {
  const char *type, *path, *meaning;
};
/// In the order of preference where several topics tell the same.
constexpr std::array<Member, 23> members = {{
    {"nav_msgs/Odometry", "pose.pose.position.x", "x"},
    {"nav_msgs/Odometry", "pose.pose.position.y", "y"},
    {"nav_msgs/Odometry", "pose.pose.orientation.yaw", "yaw"},
    {"nav_msgs/Odometry", "twist.twist.linear.x", "vx"},
    {"nav_msgs/Odometry", "twist.twist.linear.y", "vy"},
    {"nav_msgs/Odometry", "twist.twist.angular.z", "yaw rate"},
    {"geometry_msgs/PoseStamped", "pose.position.x", "x"},
    {"geometry_msgs/PoseStamped", "pose.position.y", "y"},
    {"geometry_msgs/PoseStamped", "pose.orientation.yaw", "yaw"},
    {"geometry_msgs/PoseWithCovarianceStamped", "pose.pose.position.x", "x"},
    {"geometry_msgs/PoseWithCovarianceStamped", "pose.pose.position.y", "y"},
    {"geometry_msgs/PoseWithCovarianceStamped", "pose.pose.orientation.yaw", "yaw"},
    {"geometry_msgs/TwistStamped", "twist.linear.x", "vx"},
    {"geometry_msgs/TwistStamped", "twist.linear.y", "vy"},
    {"geometry_msgs/TwistStamped", "twist.angular.z", "yaw rate"},
    {"geometry_msgs/TwistWithCovarianceStamped", "twist.twist.linear.x", "vx"},
    {"geometry_msgs/TwistWithCovarianceStamped", "twist.twist.linear.y", "vy"},
    {"geometry_msgs/TwistWithCovarianceStamped", "twist.twist.angular.z", "yaw rate"},
    {"sensor_msgs/Imu", "angular_velocity.z", "yaw rate"},
    {"sensor_msgs/NavSatFix", "latitude", "latitude"},
    {"sensor_msgs/NavSatFix", "longitude", "longitude"},
    {"ackermann_msgs/AckermannDriveStamped", "drive.steering_angle", "steering angle"},
    {"ackermann_msgs/AckermannDrive", "steering_angle", "steering angle"},
}};

std::string last_part(const std::string& text, char separator) {
  const std::size_t at = text.rfind(separator);
  return at == std::string::npos ? text : text.substr(at + 1);
}

struct Candidates {
  std::vector<Wanted> column;
  std::vector<std::string> meaning{time_column};  // of the table's columns: the time's first
  std::vector<std::string> unknown;               // topics of types that nobody defines

  void add(const Topic& topic, const std::string& path, const std::string& word) {
    column.push_back({topic.name + "." + path, false, false, {}});
    meaning.push_back(word);
  }
};

bool is_common(const std::string& type) {
  return std::any_of(members.begin(), members.end(), [&](const Member& m) { return type == m.type; });
}

/// Numbers of other types by name: the member's own, or the topic's where the member is only "data".
void add_by_name(const BagFile& bag, const Topic& topic, const Definitions& others, Candidates& to) {
  try {
    for (const std::string& path : number_paths(schema_of(bag, topic, others), 0, most_paths)) {
      const std::string member = last_part(path, '.');
      const std::string word = member == "data" ? last_part(topic.name, '/') : member;
      if (word.size() > 1 && is_channel_name(word)) to.add(topic, path, word);
    }
  } catch (const InputError&) {
    to.unknown.push_back(topic.name + " (" + short_type(topic.type) + ")");
  }
}

Candidates candidates_of(const BagFile& bag) {
  Candidates all;
  std::vector<Topic> topics;
  for (const Topic& topic : bag.topics()) {
    const auto same = [&](const Topic& other) { return other.name == topic.name; };
    const bool once = std::count_if(bag.topics().begin(), bag.topics().end(), same) == 1;
    if (topic.messages > 0 && once) topics.push_back(topic);
  }
  for (const Member& member : members)
    for (const Topic& topic : topics)
      if (short_type(topic.type) == member.type) all.add(topic, member.path, member.meaning);
  const Definitions others = definitions_for({});
  for (const Topic& topic : topics)
    if (!is_common(short_type(topic.type))) add_by_name(bag, topic, others, all);
  return all;
}

/// Of the topics that a part of a map names, the one with most messages; "" for none.
std::string busiest_of(const BagFile& bag, const Node& part) {
  const std::string text = to_json_text(part);
  const auto names = [&](const Topic& topic, char quote) {
    return text.find(quote + topic.name + ".") != std::string::npos;
  };
  const Topic* most = nullptr;
  for (const Topic& topic : bag.topics())
    if ((names(topic, '"') || names(topic, '`')) && (most == nullptr || topic.messages > most->messages)) most = &topic;
  return most == nullptr ? "" : most->name;
}

/// The topic that gives the rows: that of a reading, which is then read at its own times, not between them, where
/// linear looks ahead. A pose before speeds, as predictions are judged by it.
std::string rows_of(const BagFile& bag, const Node& map) {
  for (const char* const reading : {"/channels/x", "/channels/latitude", "/channels/vx", "/channels/yaw_rate"})
    if (const Node* const channel = find_pointer(map, reading))
      if (std::string topic = busiest_of(bag, *channel); !topic.empty()) return topic;
  return busiest_of(bag, map);
}

}  // namespace

measured::Guess guess_map(BagFile& bag) {
  const Candidates candidates = candidates_of(bag);
  std::string there;
  for (const Topic& topic : bag.topics())
    there += (there.empty() ? "" : ", ") + topic.name + " (" + short_type(topic.type) + ")";
  if (candidates.column.empty())
    throw InputError({Diagnostic{
        bag.file().string(), 0, 0, "", "no topic looks like a motion or a command of a car; found " + there, {}}});
  DelimitedTable table = read_table(bag, candidates.column, {}, most_numbers);
  table.meaning = candidates.meaning;
  measured::Guess guess = measured::guess_map(table);
  Node options = Node::empty_object();
  options.set("rows", Node(rows_of(bag, guess.map)));
  guess.map.set("bag", std::move(options));
  for (const std::string& said : table.found) guess.remarks.push_back("bag: " + said);
  for (const std::string& topic : candidates.unknown)
    guess.remarks.push_back("bag: " + topic + ": its type is not defined");
  return guess;
}

}  // namespace gripline::bags
