// Sizes of the state vector of linearised models: 6 of motion, the effects' memory, 3 unknown accelerations.
#pragma once

#include <cstddef>

#include "measured/trace.hpp"

namespace gripline::diagnose {

using measured::channels;
using measured::Channels;
using measured::Log;
using measured::Road;
using measured::Trace;

inline constexpr std::size_t max_memory = 4;    // hidden states of all effects of one model
inline constexpr std::size_t noise_states = 3;  // unknown accelerations along vx, vy, omega

/// Correlation time of the unknown accelerations [s]: they are Ornstein-Uhlenbeck processes.
inline constexpr double noise_time = 0.25;

}  // namespace gripline::diagnose
