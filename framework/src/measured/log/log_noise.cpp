#include "measured/log/log_noise.hpp"

#include <cmath>
#include <vector>

#include "measured/readings/scaled_difference.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

/// Samples from one reading of a channel to the next, but for the longest tenth.
double gap_quantile(std::span<const Log> stretches, std::size_t channel) {
  std::vector<double> gaps;
  for (const Log& log : stretches) {
    const std::vector<std::size_t> at = samples_with(log, channel);
    for (std::size_t i = 1; i < at.size(); ++i) gaps.push_back(static_cast<double>(at[i] - at[i - 1]));
  }
  return lower_quantile(std::move(gaps), 0.9, 0.0);
}

}  // namespace

double white_noise(std::span<const Log> stretches, std::size_t channel, std::size_t order) {
  const double longest = static_cast<double>(order) * gap_quantile(stretches, channel);
  std::vector<double> squares;
  for (const Log& log : stretches) {
    std::vector<double> at, reading;  // of samples
    for (const std::size_t i : samples_with(log, channel)) {
      at.push_back(static_cast<double>(i));
      reading.push_back(log.reading[i * channels + channel]);
    }
    for (std::size_t i = order; i < at.size(); ++i) {
      // Across gaps a car's own motion shows.
      if (at[i] - at[i - order] > longest) continue;
      squares.push_back(std::pow(
          scaled_difference({at.data() + (i - order), order + 1}, {reading.data() + (i - order), order + 1}), 2));
    }
  }
  // The smaller half is hardly touched by the car's own quick motions: the median of a chi-square with one degree of
  // freedom is 0.4549 of its mean.
  return std::sqrt(upper_median(std::move(squares), not_a_number) / 0.4549);
}

Channels estimate_noise(std::span<const Log> stretches) {
  Channels sigma;
  for (std::size_t c = 0; c < channels; ++c) sigma[c] = white_noise(stretches, c, 4);
  return sigma;
}

}  // namespace gripline::measured
