// Open-loop predictions along a log: from measured states, with the recorded commands, compared with what was measured.
#pragma once

#include "measured/channels.hpp"
#include "measured/replay/replay.hpp"

namespace gripline::measured {

struct RolloutOptions {
  double horizon = 1.0;    // [s]
  std::size_t first = 50;  // sample of the first start
  std::size_t every = 50;  // samples between starts
  int substeps = 2;        // of integration, per sample
};

/// One deviation counts as at most so many standard deviations: a spun car counts, but not without bound.
inline constexpr double most_deviation = 1000.0;

/// Errors of every start at every sample: prediction minus reading, starts x samples x 6; NaN where nothing was read.
struct Rollouts {
  std::vector<std::size_t> start;
  std::size_t samples = 0;
  std::vector<double> error;
  std::vector<double> predicted;  // readings predicted, same shape
};

/// `trace.motion` holds the states to start from (and along which hidden states are warmed up); predictions pass
/// through the car's own sensors and are compared with trace.log.reading.
Rollouts roll_out(const StagedCar& car, const Trace& trace, const Road& road, const RolloutOptions& options);

/// States that would give these readings through the car's sensors: n x 6 from n x 6. NaN stays.
std::vector<double> states_of_readings(const StagedCar& car, const std::vector<double>& readings,
                                       const std::vector<Place>& at);

/// Sum of squared errors over variances, and the number of readings that they are of.
struct SquaredErrors {
  double sum = 0;
  std::size_t readings = 0;
  /// Root mean square [standard deviations]; 0 without readings.
  double rms() const;
};
/// Sums errors number `first`, a multiple of `channels`, up to before `last` of Rollouts::error. What was not read does
/// not count; an error beyond `most_deviation`, or a prediction that is not a number, counts as that. `sigma`: standard
/// deviations by channel, in their units.
SquaredErrors squared_errors(const Rollouts& rollouts, std::size_t first, std::size_t last, const Channels& sigma);
/// Root mean square of all errors over standard deviations, over all samples of all starts; 0 without any.
double rms(const Rollouts& rollouts, const Channels& sigma);

}  // namespace gripline::measured
