#include "measured/readings/held_readings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace gripline::measured {
namespace test_held_readings {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

std::vector<double> every(double step, std::size_t rows) {
  std::vector<double> t;
  for (std::size_t r = 0; r < rows; ++r) t.push_back(step * static_cast<double>(r));
  return t;
}

TEST(HeldReadings, RepetitionsAreNoReadings) {
  std::vector<double> values;
  for (std::size_t r = 0; r < 40; ++r) values.push_back(std::floor(static_cast<double>(r) / 4));
  EXPECT_EQ(drop_held(every(0.01, 40), values), 30u);
  for (std::size_t r = 0; r < 40; ++r) EXPECT_EQ(std::isnan(values[r]), r % 4 != 0) << r;
}

TEST(HeldReadings, OneThatStaysForLongIsReadAtTheMedianInterval) {
  std::vector<double> values;
  for (std::size_t r = 0; r < 40; ++r) values.push_back(std::floor(static_cast<double>(r) / 4));
  values.resize(80, values.back());
  drop_held(every(0.01, 80), values);
  // New at row 36; read again after twice 0.04 s, then each 0.04 s.
  for (std::size_t r = 36; r < 80; ++r) EXPECT_EQ(std::isnan(values[r]), r != 36 && (r < 44 || r % 4 != 0)) << r;
}

TEST(HeldReadings, EmptyCellsAreNeitherNewNorHeld) {
  std::vector<double> values{1, none, 1, 2, none, 2, 3};
  EXPECT_EQ(drop_held(every(0.1, 7), values), 2u);
  EXPECT_EQ(values[0], 1);
  EXPECT_EQ(values[3], 2);
  EXPECT_EQ(values[6], 3);
}

/// A wave as a sensor of 10 Hz shows it in rows of `hertz`.
std::vector<double> slow_wave(double hertz, std::size_t rows, double step) {
  std::vector<double> values;
  for (std::size_t r = 0; r < rows; ++r) {
    const double read = std::floor(10 * static_cast<double>(r) / hertz + 1e-9) / 10;
    values.push_back(step * std::round(std::sin(read) / step));
  }
  return values;
}

TEST(HeldReadings, RowsBetweenNewOnesAreCounted) {
  EXPECT_NEAR(rows_between_new(every(0.05, 1000), slow_wave(20, 1000, 1e-6)), 2.0, 0.02);
  EXPECT_NEAR(rows_between_new(every(0.01, 1000), slow_wave(100, 1000, 1e-6)), 10.0, 0.2);
  EXPECT_NEAR(rows_between_new(every(1 / 16.0, 1000), slow_wave(16, 1000, 1e-6)), 1.6, 0.02);
  EXPECT_EQ(rows_between_new(every(0.1, 1000), slow_wave(10, 1000, 1e-6)), 1.0);
}

TEST(HeldReadings, CoarseReadingsAndACarThatStandsAreNotHeld) {
  // In steps as large as the median change from row to row some rows repeat, in no order.
  EXPECT_EQ(rows_between_new(every(0.1, 1000), slow_wave(10, 1000, 0.08)), 1.0);
  std::vector<double> stands = slow_wave(10, 300, 1e-6);
  stands.resize(1000, stands.back());
  EXPECT_EQ(rows_between_new(every(0.1, 1000), stands), 1.0);
}

}  // namespace
}  // namespace test_held_readings
}  // namespace gripline::measured
