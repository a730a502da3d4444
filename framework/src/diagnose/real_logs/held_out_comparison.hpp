// Whether one world predicts better than another, by two kinds of time that no fit saw: the time of the fitted logs
// that was kept for validation, and logs held out. Neither knows of the other, so that what they say is added.
#pragma once

#include "calibrate/fit/forecast_errors.hpp"
#include "util/statistics.hpp"

namespace gripline::diagnose {

inline constexpr double least_significance = normal_95;  // standard deviations; 97.5 %: a 95 % interval leaves out 0

/// Errors of one world on time that was not fitted.
struct UnfittedErrors {
  calibrate::ForecastErrors validation;  // of the fitted logs
  calibrate::ForecastErrors held_out;    // of logs held out; empty where there are none
  /// Whether the logs held out are long enough to decide anything: below three stretches their error has no interval.
  bool held_out_counts() const;
  /// What decides whether a world is worth more than nothing: the logs held out where they count.
  double rms() const;
};

/// How one world's errors differ from another's, by both kinds of time that count.
struct UnfittedChange {
  double significance = 0;  // of being smaller, in standard deviations (of both: Stouffer's sum)
  bool smaller = false;     // by each of them, which is a certainty above 0.5 of each
};
UnfittedChange compare_unfitted(const UnfittedErrors& with, const UnfittedErrors& without);

}  // namespace gripline::diagnose
