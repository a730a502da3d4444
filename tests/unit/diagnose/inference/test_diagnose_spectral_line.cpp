#include "diagnose/inference/spectral_line.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace gripline::diagnose {
namespace test_diagnose_spectral_line {

constexpr double pi = std::numbers::pi;

/// Noise about a wave with this many periods in all, on an offset.
std::vector<double> noisy_wave(std::size_t n, double periods) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  std::vector<double> values(n);
  for (std::size_t k = 0; k < n; ++k)
    values[k] =
        2.0 + normal(random) + 5.0 * std::sin(2.0 * pi * periods * static_cast<double>(k) / static_cast<double>(n));
  return values;
}

/// An ordinate by its definition.
double ordinate(const std::vector<double>& values, std::size_t j) {
  const auto n = static_cast<double>(values.size());
  double re = 0.0, im = 0.0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const auto at = static_cast<double>(k);
    const double y = (0.5 - 0.5 * std::cos(2.0 * pi * (at + 0.5) / n)) * values[k];
    re += y * std::cos(2.0 * pi * static_cast<double>(j) * at / n);
    im += y * std::sin(2.0 * pi * static_cast<double>(j) * at / n);
  }
  return re * re + im * im;
}

TEST(SpectralLine, OrdinatesAreThoseOfTheDefinition) {
  for (const std::size_t n : {600, 601, 1502}) {
    const std::vector<double> values = noisy_wave(n, 40.0), power = tapered_periodogram(values, n);
    ASSERT_EQ(power.size(), (n - 1) / 2) << "below Nyquist's frequency";
    for (std::size_t j = 1; j <= power.size(); ++j)
      EXPECT_NEAR(power[j - 1], ordinate(values, j), 1e-9 * ordinate(values, j)) << n << ' ' << j;
    EXPECT_EQ(std::max_element(power.begin() + 2, power.end()) - power.begin(), 39);  // the first two are the offset's
  }
}

TEST(SpectralLine, HasAsManyOrdinatesAsAreAskedForOrThereAre) {
  const std::vector<double> values = noisy_wave(100, 10.0);
  EXPECT_EQ(tapered_periodogram(values, 12).size(), 12U);
  EXPECT_EQ(tapered_periodogram(values, 50).size(), 49U);
  EXPECT_TRUE(tapered_periodogram({}, 12).empty());
  EXPECT_TRUE(tapered_periodogram(std::vector<double>{1.0, 2.0}, 12).empty());
}

}  // namespace test_diagnose_spectral_line
}  // namespace gripline::diagnose
