// What the stack sees of the true state: bias, noise, rate and delay per channel. Never friction.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <random>
#include <vector>

#include <gripline/types.hpp>
#include "config/reader.hpp"

namespace gripline {

/// Channels in the order x, y, yaw, vx, vy, yaw_rate.
inline constexpr int channel_count = 6;
struct SensorChannel {
  const char* name;
  const char* unit;
};
inline constexpr std::array<SensorChannel, channel_count> sensor_channels = {
    {{"x", "m"}, {"y", "m"}, {"yaw", "rad"}, {"vx", "m/s"}, {"vy", "m/s"}, {"yaw_rate", "rad/s"}}};

using ChannelSet = std::bitset<channel_count>;

struct SensorSpec {
  struct Channel {
    double sigma = 0.0;  // standard deviation of independent Gaussian noise
    double bias = 0.0;   // added to the reading
    int every = 1;       // control steps between readings; the last one is held
    int delay = 0;       // control steps from state to reading
    bool reads(std::int64_t step) const { return step % every == 0; }
  };
  std::array<Channel, channel_count> channels;
  /// The channels whose reading of this control step is a new one; the others show an earlier one.
  ChannelSet read_at(std::int64_t step) const;
};

/// {"sigma": {"x": "2 cm", ...}, "bias": {...}, "rate": {"x": "10 Hz"}, "delay": {...}}; times between readings must be
/// whole control steps.
SensorSpec read_sensors(const Node& node, double dt, Errors& errors);

class Sensors {
 public:
  /// `seed`: of the run, which its plugins know too.
  Sensors(SensorSpec spec, std::uint64_t seed);
  /// The reading of the state at this control step. Call once per step, in order.
  Reading<double> sense(std::int64_t step, const Reading<double>& truth);

 private:
  SensorSpec spec_;
  std::mt19937_64 random_;
  std::array<double, channel_count> held_{};
  std::vector<std::array<double, channel_count>> past_;  // ring of true states
  double normal();
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace gripline
