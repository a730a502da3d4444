#include "measured/estimates/uneven_noise.hpp"

#include <cmath>

#include "measured/readings/scaled_difference.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {

UnevenNoise::UnevenNoise(std::span<const double> times, std::optional<double> step)
    : weight_(times.size()), step_(times.size(), 1.0) {
  for (std::size_t k = 1; step && k < times.size(); ++k) step_[k] = (times[k] - times[k - 1]) / *step;
  for (std::size_t k = 4; k < times.size(); ++k) {
    Five& weight = weight_[k];
    double gain = 0.0;
    for (std::size_t i = 0; i < weight.size(); ++i) {
      weight[i] = divided_weight(times.subspan(k - 4, 5), i);
      gain += weight[i] * weight[i];
    }
    for (double& w : weight) w /= std::sqrt(gain);
  }
}

double UnevenNoise::correlation(double colour, const std::vector<std::size_t>& differences) const {
  const std::vector<double> fade = fades(colour);
  double cross = 0.0, square = 0.0;
  for (const std::size_t k : differences) {
    cross += covariance(k - 1, k, fade);
    square += 0.5 * (covariance(k - 1, k - 1, fade) + covariance(k, k, fade));
  }
  return cross / square;
}

std::vector<double> UnevenNoise::sizes(double colour) const {
  const std::vector<double> fade = fades(colour);
  std::vector<double> out(weight_.size(), not_a_number);
  for (std::size_t k = 4; k < out.size(); ++k) out[k] = std::sqrt(covariance(k, k, fade));
  return out;
}

/// By reading, the correlation of its noise with that of the one before.
std::vector<double> UnevenNoise::fades(double colour) const {
  std::vector<double> out;
  out.reserve(step_.size());
  for (const double step : step_) out.push_back(std::copysign(std::pow(std::abs(colour), step), colour));
  return out;
}

/// Of two differences, of which the second is the first or follows it.
double UnevenNoise::covariance(std::size_t first, std::size_t second, const std::vector<double>& fade) const {
  const std::size_t begin = first - 4, shift = second - first;
  std::array<std::array<double, 6>, 6> alike{};  // of readings from `begin` on
  for (std::size_t i = 0; i < 5 + shift; ++i) {
    alike[i][i] = 1.0;
    for (std::size_t j = i + 1; j < 5 + shift; ++j) alike[i][j] = alike[j][i] = alike[i][j - 1] * fade[begin + j];
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < 5; ++i)
    for (std::size_t j = 0; j < 5; ++j) sum += weight_[first][i] * weight_[second][j] * alike[i][j + shift];
  return sum;
}

}  // namespace gripline::measured
