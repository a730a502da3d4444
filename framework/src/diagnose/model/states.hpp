// Sizes of the state vector of linearised models: 6 of motion, the effects' memory, errors of rounded commands, 3
// unknown accelerations.
#pragma once

#include <cstddef>

#include "measured/replay/trace.hpp"

namespace gripline::diagnose {

using measured::Channel;
using measured::channel_info;
using measured::channels;
using measured::Channels;
using measured::Commands;
using measured::Log;
using measured::Road;
using measured::Trace;

inline constexpr std::size_t max_memory = 4;    // hidden states of all effects of one model
inline constexpr std::size_t noise_states = 3;  // unknown accelerations along vx, vy, omega

/// Correlation time [s] of the unknown accelerations, which are Ornstein-Uhlenbeck processes, until it is measured.
inline constexpr double default_noise_time = 0.25;

/// How a model is brought from sample to sample.
struct Stepping {
  Stepping(int steps, double correlation_time = default_noise_time, bool unknown_commands = false)
      : substeps(steps), noise_time(correlation_time), commands(unknown_commands) {}
  int substeps;       // of integration, per sample
  double noise_time;  // correlation time of the unknown accelerations [s]
  bool commands;      // also what commands half-way between samples do (LinearModel::by_command)
};

}  // namespace gripline::diagnose
