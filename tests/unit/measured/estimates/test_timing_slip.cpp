#include "measured/estimates/timing_slip.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/wandering_session.hpp"

namespace gripline::measured {
namespace test_timing_slip {

using test::as_it_is;
using test::wandering;

TEST(TimingSlip, APositionThatFallsBackOnceASecondIsSeen) {
  const auto late = [](double t) { return 0.008 * (t - std::floor(t)); };  // falls back 8 ms at every full second
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const Session s = wandering([&](double t, std::size_t, auto& row, auto&, auto&, auto& speed_at) {
    const double ahead = late(t + 1e-9) * speed_at(t);
    row[0] += ahead * std::cos(row[2]) + 0.004 * normal(random);
    row[1] += ahead * std::sin(row[2]) + 0.004 * normal(random);
  });
  const auto slip = timing_slip(s, 0.04);
  ASSERT_TRUE(slip);
  EXPECT_EQ(slip->period, 1.0);
  EXPECT_NEAR(slip->travel, -0.008, 0.002);
  EXPECT_FALSE(timing_slip(wandering(as_it_is), 0.04));
}

}  // namespace test_timing_slip
}  // namespace gripline::measured
