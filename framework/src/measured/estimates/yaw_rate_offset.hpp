// How far off the yaw-rate channel of logs is, by their own yaw, without a model of the car.
#pragma once

#include <optional>
#include <span>
#include <utility>

#include "measured/session/session.hpp"

namespace gripline::measured {

/// What the yaw rate shows beyond the change of yaw, a mean over time.
struct YawRateOffset {
  double value = 0;       // [rad/s]
  double sigma = 0;       // standard error, by the spread over stretches or, if larger, over logs [rad/s]
  std::size_t parts = 0;  // stretches or logs that sigma is the spread of, two or more
  /// What is as sure as three standard deviations of a normal (99.7 %), by the t distribution: wide where parts are few
  /// [rad/s].
  std::pair<double, double> range() const;
};

/// The mean offset of the yaw rate in all logs together. Empty where those that read both yaw and yaw rate have less
/// than two stretches together: of 10 s, the last of a log of 5 s at least, so that 15 s of one log are enough, or 5 s
/// of each of two. Gaps, yaws that jump (a frame that is turned) and how a log wraps its yaw do not count.
///
/// A stretch's sum S is the integral of the yaw rate less the change of yaw, over its time T; the offset is
/// sum S / sum T, a ratio estimate, of variance n / (n - 1) sum (S - offset T)^2 / (sum T)^2 (Cochran, Sampling
/// Techniques, 1977, 6.3-6.4). Noise of yaw and a yaw rate that is late err at a stretch's two ends only; where
/// stretches adjoin that error of the one is that of the other with its sign turned, so that for these the variance is,
/// if anything, too large.
///
/// Not so for what many stretches have in common: an offset that drifts or differs from log to log, and a scale of the
/// yaw rate that is off, which shows as that share of the mean turn. Of four logs or more the same variance with logs
/// in place of stretches is taken where it is larger; the spread of fewer logs is itself hardly known, and nothing of
/// this is seen.
std::optional<YawRateOffset> yaw_rate_offset(std::span<const Session* const> sessions);

}  // namespace gripline::measured
