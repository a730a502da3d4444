#include "measured/estimates/timing_slip.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/wandering_session.hpp"

namespace gripline::measured {
namespace test_timing_slip {

using test::as_it_is;
using test::wandering;

/// A car whose position falls back 8 ms at every full second; its speed is read as `wrong` once.
Session falling_back(double wrong = 0.0) {
  const auto late = [](double t) { return 0.008 * (t - std::floor(t)); };
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  return wandering([&](double t, std::size_t k, auto& row, auto&, auto&, auto& speed_at) {
    const double ahead = late(t + 1e-9) * speed_at(t);
    row[0] += ahead * std::cos(row[2]) + 0.004 * normal(random);
    row[1] += ahead * std::sin(row[2]) + 0.004 * normal(random);
    if (k == 1000 && wrong != 0.0) row[3] = wrong;
  });
}

TEST(TimingSlip, APositionThatFallsBackOnceASecondIsSeen) {
  for (const double wrong : {0.0, -9999.0}) {
    const auto slip = timing_slip(falling_back(wrong), 0.04);
    ASSERT_TRUE(slip) << wrong;
    EXPECT_EQ(slip->period, 1.0);
    EXPECT_NEAR(slip->travel, -0.008, 0.002);
  }
  EXPECT_FALSE(timing_slip(wandering(as_it_is), 0.04));
}

}  // namespace test_timing_slip
}  // namespace gripline::measured
