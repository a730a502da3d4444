#include "world/sensors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gripline {
namespace {

constexpr double most_steps = 1e6;  // true states are kept for as long as a delay lasts, 48 bytes a step

/// Steps in a time that must be a whole number of them.
int whole_steps(double time, double dt, const Node& node, const char* what, Errors& errors) {
  const double steps = time / dt;
  if (!(steps <= most_steps)) {
    errors.add(node.origin, std::string(what) + " is longer than " + number_text(most_steps * dt) +
                                " s, a million control steps of " + number_text(dt) + " s, the longest allowed");
    return 1;
  }
  const double whole = std::round(steps);
  if (std::abs(steps - whole) > 1e-6 * std::max(1.0, steps)) {
    errors.add(node.origin, std::string(what) + " is not a multiple of the control step of " + number_text(dt) +
                                " s; nearest: " + number_text(std::max(1.0, whole) * dt) + " s");
    return 1;
  }
  return static_cast<int>(whole);
}

}  // namespace

ChannelSet SensorSpec::read_at(std::int64_t step) const {
  ChannelSet read;
  for (std::size_t i = 0; i < channels.size(); ++i) read[i] = channels[i].reads(step);
  return read;
}

SensorSpec read_sensors(const Node& node, double dt, Errors& errors) {
  SensorSpec spec;
  ObjectReader r(node, errors);
  const auto each = [&](const char* key, auto&& set) {
    const Node* const by_channel = r.find(key);
    if (by_channel == nullptr) return;
    if (!by_channel->is_object())
      return errors.add(by_channel->origin,
                        std::string("expected an object by channel (x, y, yaw, vx, vy, yaw_rate), such as {\"x\": ") +
                            by_channel->describe() + "}; found " + by_channel->describe());
    ObjectReader channels = r.object(key);
    for (int i = 0; i < channel_count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const auto& [name, unit] = sensor_channels[at];
      if (const Node* value = channels.find(name); value != nullptr) set(spec.channels[at], *value, unit);
    }
    channels.finish();
  };
  each("sigma", [&](auto& channel, const Node& value, const char* unit) {
    channel.sigma = read_number(value, unit, NumberRange::non_negative(), errors);
  });
  each("bias", [&](auto& channel, const Node& value, const char* unit) {
    channel.bias = read_number(value, unit, NumberRange::any(), errors);
  });
  each("rate", [&](auto& channel, const Node& value, const char*) {
    const double rate = read_number(value, "1/s", NumberRange::positive(), errors);
    channel.every = std::max(1, whole_steps(1.0 / rate, dt, value, "the time between readings", errors));
  });
  each("delay", [&](auto& channel, const Node& value, const char*) {
    const double delay = read_number(value, "s", NumberRange::non_negative(), errors);
    channel.delay = whole_steps(delay, dt, value, "the delay", errors);
  });
  r.finish();
  return spec;
}

/// Starts elsewhere than plugins do, which get the seed itself: what they draw has nothing to do with the noise. That
/// is no secret, and no hash of so few seeds would make it one: a plugin that knows this line can draw the noise again.
Sensors::Sensors(SensorSpec spec, std::uint64_t seed) : spec_(spec), random_(seed * 0x9E3779B97F4A7C15ull + 17) {
  int longest = 0;
  for (const auto& channel : spec_.channels) longest = std::max(longest, channel.delay);
  past_.resize(static_cast<std::size_t>(longest) + 1);
}

/// Box-Muller, because std::normal_distribution differs between standard libraries.
double Sensors::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const double u = (static_cast<double>(random_() >> 11) + 0.5) * 0x1p-53;
  const double v = (static_cast<double>(random_() >> 11) + 0.5) * 0x1p-53;
  const double r = std::sqrt(-2.0 * std::log(u));
  spare_ = r * std::sin(2.0 * std::numbers::pi * v);
  has_spare_ = true;
  return r * std::cos(2.0 * std::numbers::pi * v);
}

Reading<double> Sensors::sense(std::int64_t step, const Reading<double>& truth) {
  const auto size = static_cast<std::int64_t>(past_.size());
  past_[static_cast<std::size_t>(step % size)] = {truth.x, truth.y, truth.yaw, truth.vx, truth.vy, truth.omega};
  for (int i = 0; i < channel_count; ++i) {
    const auto& channel = spec_.channels[static_cast<std::size_t>(i)];
    // Drawn whether used or not: one channel's rate does not change another's noise.
    const double noise = channel.sigma > 0.0 ? channel.sigma * normal() : 0.0;
    if (!channel.reads(step)) continue;
    const std::int64_t from = std::max<std::int64_t>(0, step - channel.delay);
    held_[static_cast<std::size_t>(i)] =
        past_[static_cast<std::size_t>(from % size)][static_cast<std::size_t>(i)] + channel.bias + noise;
  }
  return {held_[0], held_[1], held_[2], held_[3], held_[4], held_[5]};
}

}  // namespace gripline
