#include "measured/estimates/independent_blocks.hpp"

#include <gtest/gtest.h>

namespace gripline::measured {
namespace test_independent_blocks {

TEST(IndependentBlocks, AreOfTenSecondsUnlessALogIsShort) {
  EXPECT_EQ(samples_of_block(0.02, 100'000), 500u);
  EXPECT_EQ(samples_of_block(0.02, 800), 100u) << "eight of them";
  EXPECT_EQ(samples_of_block(0.02, 3), 1u);
}

}  // namespace test_independent_blocks
}  // namespace gripline::measured
