#include "measured/readings/unwrapped_angles.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "util/numbers.hpp"

namespace gripline::measured {
namespace test_unwrapped_angles {

constexpr double turn = 2.0 * std::numbers::pi;

TEST(UnwrappedAngles, FollowTheLastThatWasReadOverMissingOnes) {
  std::vector<double> angles;
  for (int k = 0; k < 100; ++k) angles.push_back(k % 7 == 3 ? not_a_number : std::remainder(3.0 + 0.2 * k, turn));
  EXPECT_EQ(unwrap_angles(angles), 4U) << "at 3.14, 9.42, 15.71 and 21.99";
  for (int k = 0; k < 100; ++k) {
    if (k % 7 != 3) {
      EXPECT_NEAR(angles[static_cast<std::size_t>(k)], 3.0 + 0.2 * k, 1e-12) << k;
    }
  }
}

TEST(UnwrappedAngles, AreEveryStrideThValueOnly) {
  std::vector<double> rows = {9.0, 3.0, 9.0, 3.0 - turn, 9.0, 3.1 + 4.0 * turn};
  EXPECT_EQ(unwrap_angles(rows, 1, 2), 2U);
  EXPECT_EQ(rows[0] + rows[2] + rows[4], 27.0);
  EXPECT_NEAR(rows[3], 3.0, 1e-12);
  EXPECT_NEAR(rows[5], 3.1, 1e-12);
}

}  // namespace test_unwrapped_angles
}  // namespace gripline::measured
