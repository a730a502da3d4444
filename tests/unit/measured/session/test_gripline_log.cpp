#include "measured/session/gripline_log.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/scratch.hpp"
#include "util/csv.hpp"

namespace gripline::measured {
namespace test_gripline_log {

using testing_support::scratch;
/// On a circle of 20 m at 10 m/s, shown by units ahead of the centre of gravity and turned, the yaw rate 0.2 s late.
SessionFile circling() {
  SessionFile file;
  Session& s = file.session;
  s.has.fill(true);
  for (int k = 0; k < 400; ++k) {
    const double t = 0.05 * k, yaw = 0.5 * t;
    const double x = 20 * std::sin(yaw), y = 20 - 20 * std::cos(yaw);
    s.t.push_back(t);
    for (const double v :
         {x + 0.3 * std::cos(yaw), y + 0.3 * std::sin(yaw), yaw + 0.02, 10.0, 0.3 * 0.5, 0.5 + 0.01 * (t - 0.2)})
      s.reading.push_back(v);
    s.command.push_back({0.1, 0.13});
  }
  file.row_step = 0.05;
  file.has_throttle = true;
  s.pose = {0.3, 0, 0.02, true, true, true};
  s.velocity = {0.3, 0, 0, true, true, false};
  return file;
}

SessionFile without_frames(SessionFile file) {
  file.session.pose = file.session.velocity = {};
  return file;
}

using Delays = std::array<double, delay_groups>;
constexpr Delays on_time{}, late_yaw_rate{0.0, 0.0, 0.0, 0.2};

TEST(GriplineLog, ColumnsAreThoseOfTheCentreOfGravityAtTheRowsTime) {
  const auto out = scratch("own.csv");
  const auto done = write_gripline_log(out, circling(), late_yaw_rate);
  EXPECT_EQ(done, std::vector<std::string>{"yaw_rate: 0.2 s taken off"});
  const CsvTable table = read_csv(out, true);
  const auto column = [&](const char* name) { return table.column(name); };
  for (std::size_t i = 0; i < 390; i += 13) {
    const double t = 0.05 * static_cast<double>(i), yaw = 0.5 * t;
    EXPECT_NEAR(column("x_m")[i], 20 * std::sin(yaw), 1e-5);
    EXPECT_NEAR(column("yaw_rad")[i], yaw, 1e-6);
    EXPECT_NEAR(column("yaw_rate_radps")[i], 0.5 + 0.01 * t, 1e-6);
    EXPECT_NEAR(column("vy_mps")[i], 0.3 * 0.5 - 0.3 * (0.5 + 0.01 * t), 1e-5);
    EXPECT_EQ(column("d")[i], 0.1);
  }
}

TEST(GriplineLog, OfADelayThatIsNotKnownNothingIsTakenOff) {
  const auto out = scratch("own.csv");
  const auto done = write_gripline_log(out, circling(), Delays{0.0, 0.0005, 0.0, NAN});
  EXPECT_EQ(done,
            std::vector<std::string>{"yaw_rate: no delay against yaw could be found, so none is taken off (one against "
                                     "a command is the car's own response too)"});
  const std::vector<double> rate = read_csv(out, true).column("yaw_rate_radps");
  for (std::size_t i = 0; i < 390; i += 13)
    EXPECT_NEAR(rate[i], 0.5 + 0.01 * (0.05 * static_cast<double>(i) - 0.2), 1e-6) << i;
}

/// Beside a delay of the same channel against a command, a sentence that none was found would contradict it.
TEST(GriplineLog, WhatADelayWasLookedForAgainstIsSaid) {
  const auto done = write_gripline_log(scratch("own.csv"), circling(), Delays{0.0, 0.0, NAN, 0.0});
  ASSERT_EQ(done.size(), 1u);
  EXPECT_TRUE(done[0].starts_with("velocity: no delay against position could be found, so none is taken off"))
      << done[0];
}

TEST(GriplineLog, WhatTheSessionLacksIsNoColumn) {
  SessionFile file = circling();
  file.has_throttle = false;
  file.session.has[4] = false;
  const auto out = scratch("own.csv");
  write_gripline_log(out, file, on_time);
  const CsvTable table = read_csv(out, true);
  EXPECT_LT(table.find("vy_mps"), 0);
  EXPECT_LT(table.find("d"), 0);
  EXPECT_GE(table.find("delta_rad"), 0);
}

/// As of a compass at 4 Hz beside places in every row.
TEST(GriplineLog, PlacesWithoutAHeadingInTheirRowAreKept) {
  SessionFile file = without_frames(circling());
  for (std::size_t i = 0; i < file.session.rows(); ++i)
    if (i % 5 != 0) file.session.reading[i * channels + Channel::yaw] = NAN;
  const auto out = scratch("own.csv");
  write_gripline_log(out, file, on_time);
  CsvTable written = read_csv(out, true);
  const auto column = [&](const char* name) { return written.column(name); };
  for (std::size_t i = 0; i < file.session.rows(); ++i) {
    EXPECT_NEAR(column("x_m")[i], file.session.at(i, Channel::x), 1e-5) << i;
    EXPECT_EQ(std::isnan(column("yaw_rad")[i]), i % 5 != 0) << i;
  }
  file.session.pose = circling().session.pose;
  write_gripline_log(out, file, late_yaw_rate);
  written = read_csv(out, true);
  for (std::size_t i = 0; i <= 395; ++i) {
    EXPECT_NEAR(column("x_m")[i], 20 * std::sin(0.025 * static_cast<double>(i)), 1e-5) << i;
    EXPECT_EQ(std::isnan(column("yaw_rad")[i]), i % 5 != 0) << i;
  }
  EXPECT_TRUE(std::isnan(column("x_m")[397])) << "behind the last heading nobody knows where the centre of gravity is";
}

/// As of a late gyroscope at 5 Hz: as many readings as before, each in the row that its time is nearest to.
TEST(GriplineLog, ADelayTakenOffLeavesAsManyReadings) {
  SessionFile file = circling();
  for (std::size_t i = 0; i < file.session.rows(); ++i)
    if (i % 4 != 0) file.session.reading[i * channels + Channel::yaw_rate] = NAN;
  const auto out = scratch("own.csv");
  write_gripline_log(out, file, Delays{0.0, 0.0, 0.0, 0.17});
  const std::vector<double> rate = read_csv(out, true).column("yaw_rate_radps");
  std::size_t read = 0;
  for (std::size_t i = 0; i < 390; ++i) {
    if (std::isnan(rate[i])) continue;
    EXPECT_NEAR(rate[i], 0.5 + 0.01 * (0.05 * static_cast<double>(i) - 0.03), 1e-6) << i;
    ++read;
  }
  EXPECT_NEAR(static_cast<double>(read), 390.0 / 4.0, 1.0);
}

}  // namespace test_gripline_log
}  // namespace gripline::measured
