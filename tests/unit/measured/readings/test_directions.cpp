#include "measured/readings/directions.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace gripline::measured {
namespace test_directions {

constexpr double pi = std::numbers::pi;

TEST(Directions, MeansDoNotDependOnTurns) {
  const std::complex<double> mean = mean_direction({pi - 0.1, -pi + 0.1, 3.0 * pi});
  EXPECT_NEAR(std::abs(std::arg(mean)), pi, 1e-12);
  EXPECT_NEAR(std::abs(mean), (1.0 + 2.0 * std::cos(0.1)) / 3.0, 1e-12);
  EXPECT_EQ(mean_direction({}), std::complex<double>());
  EXPECT_NEAR(std::abs(mean_direction({0.0, pi})), 0.0, 1e-12);
}

TEST(Directions, AreAboutZeroWhereSlipIsAllThatPartsThem) {
  EXPECT_TRUE(are_about_zero(mean_direction({-0.4, 0.0, 0.4, 2.0 * pi})));
  EXPECT_FALSE(are_about_zero(mean_direction({0.65}))) << "turned";
  EXPECT_FALSE(are_about_zero(mean_direction({-1.2, 1.2}))) << "hardly alike";
  EXPECT_TRUE(are_alike(mean_direction({0.65, 0.7, 0.65 - 2.0 * pi}))) << "about another direction";
  EXPECT_FALSE(are_alike(mean_direction({0.0, 1.0})));
}

}  // namespace test_directions
}  // namespace gripline::measured
