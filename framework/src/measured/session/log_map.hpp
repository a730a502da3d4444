// What the columns of a logger mean: a JSON map from columns to the channels of this project.
//
//   { "time":  {"column": "Time", "unit": "s"},
//     "channels": {
//       "x":        {"column": "x_m", "unit": "m", "delay": "find", "frame": {"x": "0.1 m", "y": 0, "yaw": "0 deg"}},
//       "y": ..., "yaw": ..., "vx": ..., "vy": ..., "yaw_rate": {"column": "Gyro", "unit": "deg/s", "sign": -1},
//       "d":        {"formula": "throttle / 100 - brake / 2758", "hold": "held"},
//       "delta":    {"formula": "wheel / 15", "unit": "deg"} },
//     "valid": "quality > 0.5",
//     "bag": {"rows": "/odom", "time": "header", "definitions": "msgs"} }
//
// Instead of x and y there may be "latitude" and "longitude", with "unit": "deg" where the table does not say it.
// "column": "?" is one that is still to be named.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "config/reader.hpp"
#include "measured/session/session.hpp"

namespace gripline::measured {

/// Everything a map may name beside the time. The first are the channels, a session's readings.
enum class Source : std::size_t { x, y, yaw, vx, vy, yaw_rate, d, delta, latitude, longitude };
inline constexpr std::size_t source_count = 10;
static_assert(static_cast<std::size_t>(Source::x) == Channel::x &&
              static_cast<std::size_t>(Source::yaw_rate) == Channel::yaw_rate);
struct SourceInfo {
  const char* name;
  const char* unit;    // of the channel
  const char* column;  // of a gripline log
};
const SourceInfo& source_info(Source source);

/// How one channel is made.
struct MappedChannel {
  std::string formula;
  std::string unit;  // "" where the map gives none: the table's own, else SI
  double sign = 1;
  bool command = false;
  BetweenRows between;          // only commands are paced
  std::optional<double> delay;  // [s]; empty: to be found
  Origin origin;
};

/// Channels that are stamped by one clock share a delay: four groups.
inline constexpr std::size_t delay_groups = 4;
inline constexpr std::array<const char*, delay_groups> delay_names = {"position", "yaw", "velocity", "yaw_rate"};
/// What a delay of a group is called where effects are named.
inline std::string delay_effect(std::size_t group) { return std::string(delay_names[group]) + "_delay"; }
inline constexpr std::array<std::size_t, channels> delay_group = {0, 0, 1, 2, 2, 3};

/// How a recording of ROS becomes a table (bags/bag_table.hpp); of no meaning for other logs.
struct BagOptions {
  std::string rows;                   // topic whose messages are the rows; "": the one with most among those used
  bool recorded = false;              // times of recording in place of those in headers
  std::filesystem::path definitions;  // folder of .msg files; "": none
  Origin origin;
};

struct LogMap {
  std::filesystem::path file;  // empty: a gripline log
  MappedChannel time;
  std::array<std::optional<MappedChannel>, source_count> channel;
  std::string valid;  // formula: rows where it is 0 or missing have no readings; "" for none
  Frame pose, velocity;
  BagOptions bag;

  const std::optional<MappedChannel>& operator[](Source s) const { return channel[static_cast<std::size_t>(s)]; }
  /// Delay of a group [s], 0 where the map names none of its channels; empty: to be found.
  std::optional<double> delay(std::size_t group) const;
  /// The delay of a group is to be found from `start` on [s], whatever was stated.
  void find_delay(std::size_t group, double start);
  /// Where the search for a group's delay begins [s]; empty: where the logs say.
  std::array<std::optional<double>, delay_groups> delay_start;
};

/// A column that nobody has named yet, as a guessed map writes it; such a map is refused until one is.
inline constexpr const char* unnamed_column = "?";

/// The map of a log that has gripline's own columns.
LogMap gripline_map();
/// Reads a map; problems go to `errors`.
LogMap read_log_map(const Node& node, Errors& errors);
/// A map from its file. Throws InputError.
LogMap load_log_map(const std::filesystem::path& file);

}  // namespace gripline::measured
