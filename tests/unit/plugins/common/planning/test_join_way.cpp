#include "common/planning/join_way.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gripline {
namespace test_join_way {

using planning::JoinWay;

TEST(JoinWay, BeginsWithItsOffsetAndSlopeAndEndsOnTheLine) {
  for (const double n : {-3.0, 0.0, 3.0})
    for (const double slope : {-0.4, 0.0, 0.4}) {
      const JoinWay way(n, slope, 0.02, 500);
      EXPECT_NEAR(way.at(0).n, n, 1e-12);
      EXPECT_NEAR(way.at(0).slope, slope, 1e-12);
      EXPECT_NEAR(way.at(0).bend, 0, 1e-12);
      const JoinWay::Offset last = way.at(way.length() * (1 - 1e-6));
      EXPECT_NEAR(last.n, 0, 1e-6);
      EXPECT_NEAR(last.slope, 0, 1e-6);
      EXPECT_EQ(way.at(way.length()).n, 0);
    }
}

TEST(JoinWay, SlopeAndBendAreDerivatives) {
  const JoinWay way(2, -0.3, 0.03, 500);
  const double e = 1e-4;
  for (double s = 1; s < way.length() - 1; s += 0.7) {
    const auto before = way.at(s - e), at = way.at(s), after = way.at(s + e);
    EXPECT_NEAR(at.slope, (after.n - before.n) / (2 * e), 1e-7);
    EXPECT_NEAR(at.bend, (after.slope - before.slope) / (2 * e), 1e-7);
  }
}

/// Each part keeps to the bend that was asked for; a way is the shorter the more it may bend.
TEST(JoinWay, BendsAsMuchAsItMay) {
  for (const double bend : {0.005, 0.02, 0.1})
    for (const auto& [n, slope] : {std::pair(4.0, 0.0), std::pair(0.0, 0.3), std::pair(-2.0, -0.3)}) {
      const JoinWay way(n, slope, bend, 1e4);
      double most = 0;
      for (int i = 0; i < 400; ++i) most = std::max(most, std::abs(way.at(way.length() * i / 400.0).bend));
      EXPECT_LE(most, (n * slope != 0.0 ? 2.0 : 1.001) * bend) << n << " " << slope;
      EXPECT_GE(most, 0.7 * bend);
      EXPECT_LT(JoinWay(n, slope, 2 * bend, 1e4).length(), way.length());
    }
  EXPECT_EQ(JoinWay(4, 0, 1e-6, 100).length(), 100) << "no longer than it may be";
}

/// Two parts that would turn against each other are driven as one.
TEST(JoinWay, TowardsTheLineItIsAsLongAsTheOffsetAsksFor) {
  const double bend = 0.02;
  EXPECT_EQ(JoinWay(4, -0.1, bend, 500).length(), JoinWay(4, 0, bend, 500).length());
  EXPECT_LT(JoinWay(4, -0.1, bend, 500).at(5).n, JoinWay(4, 0, bend, 500).at(5).n);
}

}  // namespace test_join_way
}  // namespace gripline
