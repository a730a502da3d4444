#include <gripline/periodic.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace gripline {
namespace test_periodic {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double periods[] = {17.84405, 1.0, 0.1, 6.283185307179586, 2403.7, 1e-3};

TEST(Periodic, ValuesInsideStay) {
  for (const double value : {0.0, 1e-300, 0.3, std::nextafter(1.0, 0.0)}) EXPECT_EQ(wrap_periodic(value, 1.0), value);
  EXPECT_EQ(wrap_periodic(1.0, 1.0), 0.0);
  EXPECT_EQ(wrap_periodic(3.25, 1.0), 0.25);
  EXPECT_EQ(wrap_periodic(-0.25, 1.0), 0.75);
}

// The quotient of a value just below a multiple may be rounded up to the whole number.
TEST(Periodic, BesideEveryMultipleOfThePeriod) {
  for (const double period : periods)
    for (int k = -50; k <= 50; ++k) {
      const double whole = k * period;
      for (const double value : {std::nextafter(whole, -infinity), whole, std::nextafter(whole, infinity)}) {
        const double wrapped = wrap_periodic(value, period);
        ASSERT_GE(wrapped, 0.0) << k << " * " << period;
        ASSERT_LT(wrapped, period) << k << " * " << period;
        ASSERT_NEAR(std::remainder(wrapped - value, period), 0.0, 1e-13 * period) << k << " * " << period;
      }
    }
}

TEST(Periodic, AQuotientRoundedUpIsTheEndOfThePeriod) {
  constexpr double period = 17.84405, value = 53.532149999999994;
  ASSERT_EQ(std::floor(value / period), 3.0) << "this value shows it no longer";
  EXPECT_NEAR(wrap_periodic(value, period), period, 1e-14);
  EXPECT_LT(wrap_periodic(value, period), period);
}

TEST(Periodic, ATinyStepBackIsTheBegin) { EXPECT_EQ(wrap_periodic(-1e-20, 17.84405), 0.0); }

TEST(Periodic, WhatHasNoPlaceIsTheBegin) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double value : {nan, infinity, -infinity}) EXPECT_EQ(wrap_periodic(value, 17.84405), 0.0) << value;
  EXPECT_EQ(wrap_periodic(20.0, nan), 0.0);
  for (const double value : {-1e300, 1e300, -1e17, 1e17}) {
    const double wrapped = wrap_periodic(value, 17.84405);
    EXPECT_TRUE(wrapped >= 0.0 && wrapped < 17.84405) << value;
  }
}

}  // namespace test_periodic
}  // namespace gripline
