// How sure a median is: its bootstrap interval, and the sign test of paired differences.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gripline {

/// The fewest values whose range covers the median in 95 % of cases: it does in 1 - 2^(1 - n). With fewer, what
/// bootstrap_median_interval() gives is the range, which covers less (50 % for two), and is called so wherever
/// it is shown.
inline constexpr std::size_t least_for_interval = 6;

struct MedianInterval {
  double lo, hi;  ///< NaN for fewer than two values
};

/// Percentile bootstrap interval of 95 % of the median (Efron, Tibshirani, "An Introduction to the Bootstrap", 1993,
/// section 13.3): the quantiles 0.025 and 0.975 of the medians of 4000 resamples, drawn from a fixed seed, so that the
/// same values give the same interval. No value may be NaN.
/// Of few values it covers the true median less often than 95 %. For odd numbers of values without ties this is exact,
/// whatever their distribution: 7 87.5 %, 9 96.1 %, 11 93.5 %, 13 90.8 %, 15 88.2 %, 17 95.1 %, 19 93.6 %, 21 92.2 %,
/// and 92.0 to 95.9 % from 23 to 51.
MedianInterval bootstrap_median_interval(std::vector<double> values);

/// Probability under "plus is as likely as minus" of signs at least as one-sided as these: the exact two-sided sign
/// test. Zeros are left out; 1 when nothing is left. No value may be NaN.
double sign_test(std::span<const double> differences);

/// The least that sign_test() can give for so many differences: all of one sign.
double least_sign_test(std::size_t differences);

}  // namespace gripline
