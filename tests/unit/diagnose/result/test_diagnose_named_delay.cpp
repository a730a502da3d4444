#include "diagnose/result/named_delay.hpp"

#include <gtest/gtest.h>

#include "diagnose/thresholds.hpp"

namespace gripline::diagnose {
namespace test_diagnose_named_delay {

TEST(NamedDelay, IsAnEffectOfMeasurementWithTheDelayAsItsOneParameter) {
  const NamedEffect delay = named_delay({.group = 3, .seconds = 0.12, .low = 0.11, .high = 0.14});
  EXPECT_EQ(delay.effect, "yaw_rate_delay");
  EXPECT_TRUE(delay.measurement);
  EXPECT_EQ(delay.confidence, thresholds::most_confidence);
  ASSERT_EQ(delay.params.size(), 1U);
  EXPECT_EQ(delay.params.front().name, "T");
  EXPECT_EQ(delay.params.front().unit, "s");
  EXPECT_EQ(delay.params.front().value, 0.12);
  EXPECT_EQ(delay.params.front().low, 0.11);
  EXPECT_EQ(delay.params.front().high, 0.14);
  EXPECT_FALSE(delay.rollout.measured()) << "that is the caller's";
}

}  // namespace test_diagnose_named_delay
}  // namespace gripline::diagnose
