// The channels that logs of cars have: pose, velocity and yaw rate.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <gripline/dual.hpp>

namespace gripline::measured {

/// The channels of a log or a session, in the order of its readings.
struct Channel {
  enum Number : std::size_t { x, y, yaw, vx, vy, yaw_rate };
};
inline constexpr std::size_t channels = 6;
using Channels = std::array<double, channels>;

struct ChannelInfo {
  const char* name;    // in maps and tables of health
  const char* words;   // in messages
  const char* unit;    // of its readings
  const char* column;  // of a gripline log
};
inline constexpr std::array<ChannelInfo, channels> channel_info = {
    {{"x", "x", "m", "x_m"},
     {"y", "y", "m", "y_m"},
     {"yaw", "yaw", "rad", "yaw_rad"},
     {"vx", "vx", "m/s", "vx_mps"},
     {"vy", "vy", "m/s", "vy_mps"},
     {"yaw_rate", "yaw rate", "rad/s", "yaw_rate_radps"}}};

/// The difference of two readings of a channel, in its unit. Headings differ by half a turn at most: how often a car
/// turned round while none was read is not known.
template <class T>
T difference_of(std::size_t channel, const T& a, const T& b) {
  constexpr double turn = 2.0 * std::numbers::pi;
  T difference = a - b;
  if (channel == Channel::yaw) difference -= turn * std::round(value(difference) / turn);
  return difference;
}

}  // namespace gripline::measured
