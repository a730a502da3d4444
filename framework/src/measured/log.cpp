#include "measured/log.hpp"

#include <algorithm>
#include <cmath>

#include "util/statistics.hpp"

namespace gripline::measured {

ActingCommand<double> command_at(const Log& log, std::size_t k, double share) {
  const CommandSample<double>& a = log.command[k];
  const CommandSample<double>& b = log.command[std::min(k + 1, log.size() - 1)];
  return {a.d + share * (b.d - a.d), a.delta + share * (b.delta - a.delta), (b.delta - a.delta) / log.dt};
}

History<double> history_at(const Log& log, double now) {
  History<double> history;
  history.samples = log.command.data();
  history.count = log.command.size();
  history.t0 = log.t0;
  history.dt = log.dt;
  history.now = now;
  history.hold = Hold::foh;
  return history;
}

Channels estimate_noise(std::span<const Log> stretches) {
  Channels sigma;
  for (std::size_t c = 0; c < channels; ++c) {
    std::vector<double> squares;
    for (const Log& m : stretches)
      for (std::size_t k = 4; k < m.size(); ++k) {
        const auto y = [&](std::size_t back) { return m.reading[(k - back) * channels + c]; };
        const double difference = y(0) - 4.0 * y(1) + 6.0 * y(2) - 4.0 * y(3) + y(4);
        if (std::isfinite(difference)) squares.push_back(difference * difference / 70.0);
      }
    // The smaller half is hardly touched by the car's own quick motions: the median of a chi-square with one degree of
    // freedom is 0.4549 of its mean.
    sigma[c] = std::sqrt(upper_median(squares, no_reading) / 0.4549);
  }
  return sigma;
}

}  // namespace gripline::measured
