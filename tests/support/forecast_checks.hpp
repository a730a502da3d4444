// What tests of the forecaster share: where predictions of a log start and how far off they are.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "calibrate/forecast/forecaster.hpp"

namespace gripline::test {

/// Starts in a log from four seconds on.
inline calibrate::Starts some_starts(const measured::Session& s, std::vector<double> horizons = {0.5, 1.0}) {
  calibrate::Starts starts;
  starts.horizons = std::move(horizons);
  for (double t = s.t.front() + 4.0; t + 1.0 < s.t.back(); t += 1.3) starts.time.push_back(s.t[s.row_before(t)]);
  return starts;
}

/// Largest error of a channel, of predictions as CalibrateRig::predict() returns them.
inline double worst(const measured::Session& s, const calibrate::Starts& starts, const std::vector<double>& predicted,
                    std::size_t channel) {
  double most = 0.0;
  const std::size_t h = starts.horizons.size();
  for (std::size_t i = 0; i < starts.time.size(); ++i)
    for (std::size_t j = 0; j < h; ++j)
      most = std::max(most, std::abs(predicted[(i * h + j) * measured::channels + channel] -
                                     s.interpolate(channel, starts.time[i] + starts.horizons[j])));
  return most;
}

/// Throttle for one second in six; in between the car comes to stand.
inline CommandSample<double> stop_and_go(double t) {
  return {std::fmod(t, 6.0) < 1.0 ? 0.3 : 0.0, 0.2 * std::sin(2 * t)};
}

}  // namespace gripline::test
