// One car, or one effect, at one instant, as a batch of one.
#pragma once

#include "car/staged_car.hpp"

namespace gripline {

/// A command that has always been what it is now: `now` must outlive it. With one sample `dt`, which must not be 0, and
/// `hold` change nothing.
template <class T>
History<T> always(const CommandSample<T>& now, double dt = 0.01, Hold hold = Hold::foh) {
  return {&now, 1, 0.0, dt, 0.0, hold};
}

/// A car whose command has always been the one it has now. Holds what the batch points to: neither copied nor moved.
/// `motion` (motion_size numbers) and `at` must outlive it; rates, memory and parameters are set by the caller.
template <class T>
struct InstantBatch {
  InstantBatch(const T* motion, const ActingCommand<T>& now, const Place& at, double dt, Hold hold)
      : command(now), sample{now.d, now.delta}, history(always(sample, dt, hold)) {
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

/// An effect at an instant, under a command that has always been `now`. Holds what the points point to: neither copied
/// nor moved. `at` and `params` must outlive it; quantities or reading, and memory, are set by the caller.
struct InstantPoints {
  InstantPoints(const CommandSample<double>& now, const Place& at, const double* params)
      : sample(now), history(always(sample)) {
    points.n = 1;
    points.at = &at;
    points.params = params;
    points.history = &history;
  }
  InstantPoints(const InstantPoints&) = delete;
  InstantPoints& operator=(const InstantPoints&) = delete;

  CommandSample<double> sample;
  History<double> history;
  Points<double> points;
};

}  // namespace gripline
