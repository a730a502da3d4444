// A plugin of any kind, called as a race would call it, step by step, with its answers as numbers.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "conformance/bench.hpp"

namespace gripline::conformance {

/// Where an answer is kept: null when it is not wanted, so that a step makes no allocation of the kit's.
using Answers = std::vector<double>*;

class Exercise {
 public:
  virtual ~Exercise() = default;
  /// One control step. `k` counts on for ever; what a plugin is given repeats after the drive on record.
  virtual void step(std::int64_t k, Answers answers) = 0;
  /// Calls outside the ordinary: standstill, reverse, full lock, far off the road, the wrong way round. Adds what was
  /// answered. `where` is set before each call to words for messages.
  virtual void extremes(const char*& where, Answers answers) = 0;
  /// The `const` calls, which may come from several threads at once; the same answers every time.
  virtual void ask(Answers answers) const = 0;
};

/// Makes an instance and what calls it. Throws PluginError when the instance cannot be made.
std::unique_ptr<Exercise> make_exercise(const PluginEntry& entry, Bench& bench, const PluginContext& context,
                                        const std::vector<abi::ParamValue>& values);

/// What became of a car that a controller drives once around the oval along its centre line at 0.8 m/s.
struct Lap {
  double largest_d = 0;       ///< beyond its limits [-]
  double largest_ddelta = 0;  ///< beyond the limit [rad/s]
  double largest_delta = 0;   ///< beyond the limit of the steering angle commanded [rad]
  double farthest = 0;        ///< from the centre line [m]
  double covered = 0;         ///< along it [m]
  double length = 0;          ///< of the lap [m]
  std::int64_t steps = 0, unsolved = 0;
  bool cut_short = false;  ///< 5 s of CPU were not enough for the whole of it
};
Lap drive_lap(const PluginEntry& entry, Bench& bench, const std::vector<abi::ParamValue>& values);

/// The rms of vx', vy', omega' that the nominal model leaves unexplained on a part of the drive that the estimator did
/// not see, and what is left of each with its correction, as a share.
struct Learned {
  double left[3] = {1, 1, 1};
  bool cut_short = false;  ///< 5 s of CPU were not enough to be taught the whole drive
  Belief belief;
};
Learned learn(const PluginEntry& entry, Bench& bench, const std::vector<abi::ParamValue>& values);

}  // namespace gripline::conformance
