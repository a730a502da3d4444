// One channel whose noise is known, for tests of what estimates noise.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "measured/channels.hpp"
#include "util/numbers.hpp"

namespace gripline::test::noisy_channel {

using measured::Channel;
using measured::channels;

inline constexpr double sample_time = 0.04;  // [s]
inline constexpr double sigma = 0.05;        // of the noise [m/s]
inline constexpr std::size_t read_channel = Channel::vx, samples = 5000;

/// A smooth speed [m/s].
inline double motion(std::size_t k) {
  const double t = static_cast<double>(k) * sample_time;
  return 15.0 + 3.0 * std::sin(0.4 * t) + std::sin(1.9 * t);
}

/// Rows of readings of that channel alone, with noise of a standard deviation `sigma` and a lag-one correlation
/// `colour`.
inline std::vector<double> noisy(double colour) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  std::vector<double> reading(samples * channels, not_a_number);
  double state = normal(random);
  for (std::size_t k = 0; k < samples; ++k) {
    reading[k * channels + read_channel] = motion(k) + sigma * state;
    state = colour * state + std::sqrt(1 - colour * colour) * normal(random);
  }
  return reading;
}

}  // namespace gripline::test::noisy_channel
