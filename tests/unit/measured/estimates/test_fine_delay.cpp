#include "measured/estimates/fine_delay.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "util/numbers.hpp"

namespace gripline::measured {
namespace test_fine_delay {

constexpr double dt = 0.02;

/// A rate that is late, of another scale and off by an offset, and what it sums to; white noise in both.
struct Channels {
  std::vector<double> rate, sum;
};
Channels late(double seconds, double noise, double scale = 1.0, double offset = 0.0) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  Channels out;
  for (int k = 0; k < 2000; ++k) {
    const double t = k * dt, ago = t - seconds;
    out.sum.push_back(2.0 * std::sin(1.3 * t) + 0.3 * std::sin(5.1 * t) + 0.007 * noise * normal(random));
    out.rate.push_back(scale * (2.6 * std::cos(1.3 * ago) + 1.53 * std::cos(5.1 * ago)) + offset +
                       0.05 * noise * normal(random));
  }
  return out;
}

TEST(FineDelay, IsFoundToASmallPartOfASample) {
  for (const double seconds : {0.0, 0.004, 0.12, 0.287, -0.11}) {
    const Channels exact = late(seconds, 0.0), noisy = late(seconds, 1.0);
    const double start = seconds + 0.006;  // as a correlation may be off
    EXPECT_NEAR(fine_delay(exact.rate, exact.sum, dt, start).value(), seconds, 1e-5) << seconds;
    EXPECT_NEAR(fine_delay(noisy.rate, noisy.sum, dt, start).value(), seconds, 3e-4) << seconds;
  }
}

TEST(FineDelay, ScaleAndOffsetOfTheRateAreNoDelay) {
  const Channels c = late(0.1, 0.0, 1.1, 0.3);
  EXPECT_NEAR(fine_delay(c.rate, c.sum, dt, 0.1).value(), 0.1, 1e-4);
}

TEST(FineDelay, GapsAreLeftOut) {
  Channels c = late(0.1, 0.0);
  for (std::size_t k = 500; k < 560; ++k) c.rate[k] = not_a_number;
  for (std::size_t k = 900; k < 905; ++k) c.sum[k] = not_a_number;
  EXPECT_NEAR(fine_delay(c.rate, c.sum, dt, 0.1).value(), 0.1, 1e-5);
  std::fill(c.sum.begin() + 60, c.sum.end(), not_a_number);
  EXPECT_FALSE(fine_delay(c.rate, c.sum, dt, 0.1));
  EXPECT_FALSE(fine_delay(std::vector<double>(5, 1.0), std::vector<double>(5, 1.0), dt, 0.0));
}

}  // namespace test_fine_delay
}  // namespace gripline::measured
