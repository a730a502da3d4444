#include "car/effect_order.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace gripline {
namespace test_effect_order {

TEST(EffectOrder, OneMoreActsBeforeTheFirstOfItsStageThatHasAHigherPrecedence) {
  const std::vector<EffectOrder> chain = {
      {Stage::reading, 1}, {Stage::command, 30}, {Stage::command, 10}, {Stage::command, 20}, {Stage::reading, 5}};
  EXPECT_EQ(place_in_chain({Stage::command, 9}, chain), 1U) << "the world's own order stays";
  EXPECT_EQ(place_in_chain({Stage::command, 30}, chain), 5U) << "of one precedence the one that was there acts first";
  EXPECT_EQ(place_in_chain({Stage::reading, 1}, chain), 4U);
  EXPECT_EQ(place_in_chain({Stage::reading, 0}, chain), 0U);
  EXPECT_EQ(place_in_chain({Stage::load, 0}, chain), 5U) << "none of its stage";
  EXPECT_EQ(place_in_chain({Stage::load, 0}, {}), 0U);
}

}  // namespace test_effect_order
}  // namespace gripline
