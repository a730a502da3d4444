// Whether one world predicts better than another, by two kinds of time that no fit saw: the rest of the fitted logs,
// and logs held out. Neither knows of the other, so that what they say is added.
#pragma once

#include "calibrate/forecast_errors.hpp"

namespace gripline::calibrate {

inline constexpr double sure_enough = 1.96;  // standard deviations; 97.5 %: a 95 % interval leaves out 0

/// Errors of one world.
struct WitnessErrors {
  ForecastErrors own;       // of time of the fitted logs that is not fitted
  ForecastErrors held_out;  // of logs held out; empty where there are none
  /// Whether the logs held out are long enough to say anything: below three stretches their error has no interval.
  bool held_out_says() const;
  /// What decides whether a world is worth more than nothing: the logs held out where they have a say.
  double rms() const;
};

/// What the witnesses that have a say tell of one world beside another.
struct WitnessChange {
  double sure = 0;       // that it predicts better, in standard deviations (two witnesses: Stouffer's sum)
  bool smaller = false;  // each of them has smaller errors with it, which is a certainty above 0.5 of each
};
WitnessChange compare(const WitnessErrors& with, const WitnessErrors& without);

}  // namespace gripline::calibrate
