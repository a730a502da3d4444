#include "measured/estimates/uneven_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

namespace gripline::measured {
namespace test_uneven_noise {

const std::vector<double> even = {0.0, 0.1, 0.2, 0.3, 0.4, 0.5}, uneven = {0.0, 0.14, 0.2, 0.31, 0.36, 0.5};

TEST(UnevenNoise, ThatIsWhiteLeavesDifferencesOfItsOwnSize) {
  for (const auto& times : {even, uneven}) {
    const std::vector<double> size = UnevenNoise(times, 0.1).sizes(0.0);
    ASSERT_EQ(size.size(), times.size());
    EXPECT_TRUE(std::isnan(size[3]));
    EXPECT_NEAR(size[4], 1.0, 1e-12);
    EXPECT_NEAR(size[5], 1.0, 1e-12);
  }
  EXPECT_NEAR(UnevenNoise(even, 0.1).correlation(0.0, {5}), -56.0 / 70.0, 1e-9) << "binomial coefficients";
}

TEST(UnevenNoise, ThatIsColouredLeavesLessWhereReadingsAreNear) {
  const double c = 0.5;
  const double covariance = 70.0 - 2.0 * 56.0 * c + 2.0 * 28.0 * c * c - 2.0 * 8.0 * c * c * c + 2.0 * c * c * c * c;
  EXPECT_NEAR(UnevenNoise(even, 0.1).sizes(c)[4], std::sqrt(covariance / 70.0), 1e-9);
  EXPECT_NEAR(UnevenNoise(even, 0.1).sizes(-c)[4], std::sqrt((70.0 + 56.0 + 14.0 + 2.0 + 0.125) / 70.0), 1e-9);
  EXPECT_LT(UnevenNoise(uneven, 0.1).sizes(c)[4], UnevenNoise(even, 0.1).sizes(c)[4]);
  EXPECT_NEAR(UnevenNoise(even, 0.2).sizes(c * c)[4], UnevenNoise(even, 0.1).sizes(c)[4], 1e-9) << "fades with time";
  EXPECT_NEAR(UnevenNoise(even, std::nullopt).sizes(c)[4], UnevenNoise(even, 0.1).sizes(c)[4], 1e-9);
  EXPECT_NE(UnevenNoise(uneven, std::nullopt).sizes(c)[4], UnevenNoise(uneven, 0.1).sizes(c)[4]);
}

}  // namespace test_uneven_noise
}  // namespace gripline::measured
