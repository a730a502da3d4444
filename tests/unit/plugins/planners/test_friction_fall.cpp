#include "planners/time_optimal/friction_fall.hpp"

#include <gtest/gtest.h>

#include <cstddef>

namespace gripline {
namespace test_friction_fall {

using time_optimal::FrictionFall;
using time_optimal::SeenFriction;

constexpr double unsure = 0.1;  // standard deviation: twice that is more than a fall of a tenth

TEST(SeenFriction, IsEvidenceOfLessAlsoWhereItIsNotSure) {
  EXPECT_TRUE((SeenFriction{0, 0.9, 0.04, 1}.sure()));
  EXPECT_FALSE((SeenFriction{0, 0.9, 0.05, 1}.sure()));
  EXPECT_TRUE((SeenFriction{0, 0.6, unsure, 1}.below(0.81)));
  EXPECT_FALSE((SeenFriction{0, 0.6, unsure, 1}.below(0.79)));
  EXPECT_FALSE((SeenFriction{0, 0.6, 0.0, -1}.below(0.81)));  // never seen
}

/// A belief of 0.9 on piece 10 that fell to 0.6 on piece 12: two pieces a step of 20 ms, and 0.3 s to detect it.
class FrictionFallTest : public ::testing::Test {
 protected:
  FrictionFall::Now see(double mu, double spread = 0.0) {
    ++step_;
    return fall_.see({piece(), mu, spread, step_});
  }
  /// The same belief in so many steps; what was made of the last one.
  FrictionFall::Now see_for(int steps, double mu, double spread = 0.0) {
    FrictionFall::Now now = see(mu, spread);
    for (int i = 1; i < steps; ++i) now = see(mu, spread);
    return now;
  }
  std::size_t piece() const { return 2 * static_cast<std::size_t>(step_); }

  long step_ = 6;
  FrictionFall fall_{{10, 0.9, 0.0, 5}, 0.9, {12, 0.6, unsure, 6}, 0.02, 0.3};
};

TEST_F(FrictionFallTest, IsOverWhenTheBeliefHasBeenBackForAFifthOfASecond) {
  EXPECT_EQ(see_for(9, 0.6), FrictionFall::Now::lasts);
  const std::size_t last = piece();
  EXPECT_EQ(see_for(9, 0.9), FrictionFall::Now::back);
  EXPECT_FALSE(fall_.is_over());
  see_for(2, 0.9);
  EXPECT_TRUE(fall_.is_over());
  EXPECT_EQ(fall_.last(), last);
  EXPECT_NEAR(fall_.evidence(), 0.2, 1e-9);  // with the first one
}

// What a learner believed too much of does not come back as high.
TEST_F(FrictionFallTest, IsBackAtTwoThirdsOfTheWay) {
  see(0.6);
  EXPECT_EQ(see(0.79), FrictionFall::Now::lasts);
  EXPECT_EQ(see(0.805), FrictionFall::Now::back);
  EXPECT_EQ(see(0.805, unsure), FrictionFall::Now::lasts);
}

TEST_F(FrictionFallTest, IsSureOnceABeliefWas) {
  EXPECT_FALSE(fall_.is_sure());
  see(0.6, unsure);
  EXPECT_FALSE(fall_.is_sure());
  see(0.6);
  EXPECT_TRUE(fall_.is_sure());
  see(0.6, unsure);
  EXPECT_TRUE(fall_.is_sure());
}

// Doubt behind a place is not of it, and less friction after a long doubt is another fall.
TEST_F(FrictionFallTest, EndsWithItsLastEvidenceWhereDoubtLasts) {
  see(0.6);
  const std::size_t low = piece();
  EXPECT_EQ(see_for(14, 0.8, unsure), FrictionFall::Now::lasts);
  EXPECT_EQ(fall_.last(), piece());
  see_for(3, 0.8, unsure);
  EXPECT_EQ(fall_.last(), low);
  EXPECT_EQ(see(0.6), FrictionFall::Now::again);
}

TEST_F(FrictionFallTest, BeginsWhereItWasToldTo) {
  EXPECT_EQ(fall_.begin(), 10u);
  fall_.begin_at(8);
  EXPECT_EQ(fall_.begin(), 8u);
  EXPECT_FALSE(fall_.has_joined());
  fall_.join(14);
  EXPECT_TRUE(fall_.has_joined());
  EXPECT_EQ(fall_.begin(), 8u);
  EXPECT_EQ(fall_.joined(), 14u);
}

}  // namespace test_friction_fall
}  // namespace gripline
