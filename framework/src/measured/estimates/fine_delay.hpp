// A delay between a channel and the rate of another that shows the same motion, to a small part of a sample: the best
// lag of a correlation is off by some hundredths of one, which in a precise channel is more than its noise.
#pragma once

#include <optional>
#include <span>

namespace gripline::measured {

/// By how much `rate` is later than the rate of `sum` [s], near `start`; both on one grid of `dt` [s], NaN where
/// nothing was read. Least squares of the changes of `sum` within half a second,
///   sum(t + w) - sum(t) = (1 + scale) integral of rate from t + T to t + T + w, + offset w,
/// for T, the scale and the offset of the rate. Empty where fewer than fifty such changes are known.
std::optional<double> fine_delay(std::span<const double> rate, std::span<const double> sum, double dt, double start);

}  // namespace gripline::measured
