#include "measured/readings/scaled_difference.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace gripline::measured {
namespace test_scaled_difference {

constexpr std::array<double, 5> even = {0, 1, 2, 3, 4}, uneven = {0.5, 0.6, 0.9, 1.0, 1.4};

TEST(ScaledDifference, OfEvenReadingsIsTheFourthDifference) {
  const std::array<double, 5> y = {1, 4, -2, 0.5, 3};
  EXPECT_NEAR(scaled_difference(even, y), (1 - 4 * 4 + 6 * -2 - 4 * 0.5 + 3) / std::sqrt(70.0), 1e-12);
}

TEST(ScaledDifference, NoiseOfOneHasTheSizeOneAndAMotionOfALowerOrderNone) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (const auto& at : {even, uneven}) {
    std::array<double, 5> y{};
    double square = 0.0;
    constexpr int draws = 20'000;
    for (int k = 0; k < draws; ++k) {
      for (double& v : y) v = normal(random);
      square += std::pow(scaled_difference(at, y), 2);
    }
    EXPECT_NEAR(square / draws, 1.0, 0.05);
    for (std::size_t i = 0; i < y.size(); ++i) y[i] = 1 + 2 * at[i] - std::pow(at[i], 3);
    EXPECT_NEAR(scaled_difference(at, y), 0.0, 1e-10);
  }
}

}  // namespace test_scaled_difference
}  // namespace gripline::measured
