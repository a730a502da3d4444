// One car at one instant, as a batch of one.
#pragma once

#include "car/staged_car.hpp"

namespace gripline {

/// A car whose command has always been the one it has now. Holds what the batch points to: neither copied nor moved.
/// `motion` (motion_size numbers) and `at` must outlive it; rates, memory and parameters are set by the caller.
template <class T>
struct InstantBatch {
  InstantBatch(const T* motion, const ActingCommand<T>& now, const Place& at, double dt, Hold hold)
      : command(now), sample{now.d, now.delta}, history{&sample, 1, 0.0, dt, 0.0, hold} {
    batch.n = 1;
    batch.motion = motion;
    batch.command = &command;
    batch.at = &at;
    batch.history = &history;
  }
  InstantBatch(const InstantBatch&) = delete;
  InstantBatch& operator=(const InstantBatch&) = delete;

  ActingCommand<T> command;
  CommandSample<T> sample;
  History<T> history;
  CarBatch<T> batch;
};

}  // namespace gripline
