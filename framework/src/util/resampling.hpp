// How sure a median is: its bootstrap interval, and the sign test of paired differences.
#pragma once

#include <span>
#include <vector>

namespace gripline {

struct MedianInterval {
  double lo, hi;  ///< NaN for fewer than two values
};

/// Percentile bootstrap interval of 95 % of the median (Efron, Tibshirani, "An Introduction to the Bootstrap", 1993,
/// section 13.3): the quantiles 0.025 and 0.975 of the medians of 4000 resamples, drawn from a fixed seed, so that the
/// same values give the same interval. No value may be NaN.
MedianInterval bootstrap_median_interval(std::vector<double> values);

/// Probability under "plus is as likely as minus" of signs at least as one-sided as these: the exact two-sided sign
/// test. Zeros are left out; 1 when nothing is left. No value may be NaN.
double sign_test(std::span<const double> differences);

}  // namespace gripline
