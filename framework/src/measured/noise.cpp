#include "measured/noise.hpp"

#include <array>
#include <cmath>

#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

/// Samples from one reading of a channel to the next, but for the longest tenth.
double usual_gap(std::span<const Log> stretches, std::size_t channel) {
  std::vector<double> gaps;
  for (const Log& log : stretches) {
    const std::vector<std::size_t> at = samples_with(log, channel);
    for (std::size_t i = 1; i < at.size(); ++i) gaps.push_back(static_cast<double>(at[i] - at[i - 1]));
  }
  return lower_quantile(std::move(gaps), 0.9, 0.0);
}

/// Divided difference of a channel's readings at these samples, over the standard deviation that white noise of one
/// gives it.
double scaled_difference(const Log& log, std::size_t channel, std::span<const std::size_t> at) {
  double difference = 0.0, gain = 0.0;
  for (const std::size_t here : at) {
    double weight = 1.0;
    for (const std::size_t other : at)
      if (other != here) weight /= static_cast<double>(here) - static_cast<double>(other);
    difference += weight * log.reading[here * channels + channel];
    gain += weight * weight;
  }
  return difference / std::sqrt(gain);
}

}  // namespace

double white_noise(std::span<const Log> stretches, std::size_t channel, std::size_t order) {
  const double longest = static_cast<double>(order) * usual_gap(stretches, channel);
  std::vector<double> squares;
  for (const Log& log : stretches) {
    const std::vector<std::size_t> at = samples_with(log, channel);
    for (std::size_t i = order; i < at.size(); ++i) {
      // Across gaps a car's own motion shows.
      if (static_cast<double>(at[i] - at[i - order]) > longest) continue;
      squares.push_back(std::pow(scaled_difference(log, channel, {at.data() + (i - order), order + 1}), 2));
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

namespace {

/// Covariance at a lag of the fourth differences of a first-order process of variance 1.
double fourth_difference_covariance(double colour, int lag) {
  constexpr std::array<double, 5> c = {1, -4, 6, -4, 1};
  double sum = 0.0;
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j)
      sum += c[static_cast<std::size_t>(i)] * c[static_cast<std::size_t>(j)] * std::pow(colour, std::abs(i - j + lag));
  return sum;
}

}  // namespace

std::optional<Noise> noise_of(const Session& session, std::size_t channel, double row_step) {
  std::vector<double> difference(session.rows(), not_a_number), sizes;
  for (std::size_t i = 4; i < session.rows(); ++i) {
    if (session.t[i] - session.t[i - 4] > 4.6 * row_step) continue;
    const auto y = [&](std::size_t back) { return session.at(i - back, channel); };
    difference[i] = y(0) - 4.0 * y(1) + 6.0 * y(2) - 4.0 * y(3) + y(4);
    if (!std::isnan(difference[i])) sizes.push_back(std::abs(difference[i]));
  }
  if (sizes.size() < 100) return std::nullopt;
  Noise noise;
  noise.samples = sizes.size();
  const double scale = median(sizes) / 0.6745;  // of a normal distribution
  if (!(scale > 0.0)) return noise;
  double cross = 0.0, square = 0.0;
  for (std::size_t i = 1; i < difference.size(); ++i) {
    const double a = difference[i - 1], b = difference[i];
    if (!(std::abs(a) < 4.0 * scale) || !(std::abs(b) < 4.0 * scale)) continue;
    cross += a * b;
    square += 0.5 * (a * a + b * b);
  }
  const double seen = cross / square;
  double low = -0.95, high = 0.99;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    const double expected = fourth_difference_covariance(middle, 1) / fourth_difference_covariance(middle, 0);
    (expected < seen ? low : high) = middle;
  }
  noise.colour = 0.5 * (low + high);
  noise.sigma = scale / std::sqrt(fourth_difference_covariance(noise.colour, 0));
  return noise;
}

}  // namespace gripline::measured
