#include "measured/log/raw_log.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gripline::measured {
namespace test_raw_log {

/// The sample time found in ten minutes of rows at this rate, each stamp late by up to 0.2 ms, written to the
/// microsecond.
double found_step(double hertz) {
  RawLog raw;
  const auto rows = static_cast<std::size_t>(600.0 * hertz);
  for (std::size_t k = 0; k < rows; ++k) {
    const double late = 1e-4 * (1.0 + std::sin(1.7 * static_cast<double>(k)));
    raw.t.push_back(std::round((static_cast<double>(k) / hertz + late) * 1e6) * 1e-6);
  }
  std::vector<Finding> health;
  return check_time({}, raw, health);
}

TEST(RawLog, TheSampleTimeIsAWholeNumberOfMicrosecondsWhereTheStampsKeepToIt) {
  for (const double hertz : {10.0, 25.0, 50.0, 100.0, 200.0})
    EXPECT_NEAR(found_step(hertz), 1.0 / hertz, 1e-15) << hertz;
}

TEST(RawLog, ALongLogKeepsToItsStampsAtAnyRate) {
  for (const double hertz : {24.0, 30.0, 60.0, 120.0})
    EXPECT_NEAR(found_step(hertz) * 600.0 * hertz, 600.0, 0.1 / hertz) << hertz;
}

/// As of messages of a bus, each in a row of its own.
TEST(RawLog, TheSampleTimeOfRowsInBurstsIsTheirMean) {
  std::vector<double> times;
  for (std::size_t k = 0; k < 400; ++k)
    times.push_back(0.05 * static_cast<double>(k / 4) + 6e-5 * static_cast<double>(k % 4));
  EXPECT_NEAR(sampling_interval(times), 0.0125, 2e-4);
  EXPECT_EQ(sampling_interval({}), 0.0);
}

}  // namespace test_raw_log
}  // namespace gripline::measured
