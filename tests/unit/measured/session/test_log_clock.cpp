#include "measured/session/log_clock.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "util/numbers.hpp"

namespace gripline::measured::test_log_clock {
namespace {

TEST(LogClock, StampsOfUnixTimeBecomeTheDecimalsThatWereWritten) {
  constexpr double begin = 1712345678.25;
  std::vector<double> times, expected;
  for (int i = 0; i < 2000; ++i) {
    times.push_back(begin + 0.01 * i);
    expected.push_back(i / 100.0);
  }
  EXPECT_EQ(times_since(begin, times, times.back()), expected);
}

TEST(LogClock, ALogThatBeginsAtZeroStaysAsItIs) {
  const std::vector<double> times = {0.0, 1.0 / 3.0, 0.7123456789012345};
  EXPECT_EQ(times_since(0.0, times, 1.0), times);
}

TEST(LogClock, RowsCloserThanTheDigitsStayApart) {
  const double begin = 1712345678.0, next = std::nextafter(begin, 2e9);
  const std::vector<double> since = times_since(begin, {begin, next}, next);
  EXPECT_GT(since[1], since[0]);
}

TEST(LogClock, ARowWithoutTimeHasNone) { EXPECT_TRUE(std::isnan(times_since(5.0, {5.0, not_a_number, 6.0}, 6.0)[1])); }

}  // namespace
}  // namespace gripline::measured::test_log_clock
