#include "util/normal_draw.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gripline {
namespace test_normal_draw {

TEST(NormalDraw, HasMeanZeroAndUnitDeviation) {
  std::mt19937 random(1);
  constexpr int draws = 20000;
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < draws; ++i) {
    const double draw = nearly_normal(random);
    sum += draw;
    squares += draw * draw;
  }
  EXPECT_NEAR(sum / draws, 0.0, 0.03);  // four standard errors
  EXPECT_NEAR(std::sqrt(squares / draws), 1.0, 0.02);
}

TEST(NormalDraw, TakesTwelveNumbers) {
  std::mt19937 random(7), again(7);
  (void)nearly_normal(random);
  again.discard(12);
  EXPECT_EQ(random(), again());
}

}  // namespace test_normal_draw
}  // namespace gripline
