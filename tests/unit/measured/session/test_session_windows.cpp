#include "measured/session/session_windows.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace gripline::measured {
namespace test_session_windows {

using testing::IsEmpty;
using testing::SizeIs;

/// A car that drives a circle to the left at 10 m/s: yaw rate 0.4 rad/s, steering 0.1 rad, throttle 0.3; a row every
/// `dt` [s].
Session circling(double dt, double seconds) {
  constexpr double v = 10.0, rate = 0.4;
  Session s;
  s.has.fill(true);
  const auto rows = static_cast<std::size_t>(std::round(seconds / dt)) + 1;
  for (std::size_t k = 0; k < rows; ++k) {
    const double t = dt * static_cast<double>(k), yaw = rate * t;
    s.t.push_back(t);
    for (const double one : {v / rate * std::sin(yaw), -v / rate * std::cos(yaw), yaw, v, -0.2, rate})
      s.reading.push_back(one);
    s.command.push_back({0.3, 0.1});
  }
  return s;
}

double& reading(Session& s, std::size_t row, std::size_t channel) { return s.reading[row * channels + channel]; }

TEST(SessionWindows, AreOfHalfASecondAndOverlapByHalf) {
  Session s = circling(0.02, 10.0);
  for (std::size_t k = 0; k < s.rows(); ++k) reading(s, k, Channel::vx) += 0.5 * s.t[k];
  const std::vector<SessionWindow> windows = session_windows(s);
  ASSERT_THAT(windows, SizeIs(40));
  EXPECT_NEAR(windows[1].begin, 0.24, 1e-12) << "half of 25 rows";
  const SessionWindow& w = windows.front();
  EXPECT_NEAR(w.seconds, 0.5, 1e-12);
  EXPECT_NEAR(w.way, 2.0 * 25.0 * std::sin(0.1), 1e-9) << "the chord of 0.2 rad";
  EXPECT_NEAR(w.course, 0.1, 1e-9);
  EXPECT_NEAR(w.turn, 0.2, 1e-12);
  EXPECT_NEAR(w.heading, 0.1, 1e-12);
  EXPECT_NEAR(w.yaw, 0.1, 1e-12);
  EXPECT_NEAR(w.speed, 10.125, 1e-12);
  EXPECT_NEAR(w.side, -0.2, 1e-12);
  EXPECT_NEAR(w.rate, 0.4, 1e-12);
  EXPECT_NEAR(w.steer, 0.1, 1e-12);
  EXPECT_NEAR(w.throttle, 0.3, 1e-12);
  EXPECT_NEAR(w.gain, 0.25, 1e-12);
}

TEST(SessionWindows, AreLongerWhereRowsAreSparseUpToASecond) {
  const std::vector<SessionWindow> windows = session_windows(circling(0.8, 40.0));
  ASSERT_THAT(windows, SizeIs(50));
  for (const SessionWindow& w : windows) EXPECT_NEAR(w.seconds, 0.8, 1e-9);
  EXPECT_THAT(session_windows(circling(1.2, 60.0)), IsEmpty());
}

/// The car does not stand between places that are repeated until there is a new one.
TEST(SessionWindows, APlaceThatIsRepeatedIsNoneOfItsOwn) {
  Session s = circling(0.02, 20.0);
  for (std::size_t k = 0; k < s.rows(); ++k)
    for (const std::size_t c : {Channel::x, Channel::y}) reading(s, k, c) = reading(s, k - k % 10, c);
  const std::vector<SessionWindow> windows = session_windows(s);
  ASSERT_THAT(windows, SizeIs(testing::Gt(70)));
  for (const SessionWindow& w : windows) EXPECT_NEAR(w.way / w.seconds, 10.0, 0.05) << w.begin;
}

/// Places every two seconds.
TEST(SessionWindows, AreBridgedOverWhatUsuallyLiesBetweenPlacesOrLess) {
  Session s = circling(0.02, 20.0);
  for (std::size_t k = 0; k < s.rows(); ++k)
    if (k % 100 != 0) reading(s, k, Channel::x) = reading(s, k, Channel::y) = NAN;
  for (const SessionWindow& w : session_windows(s)) EXPECT_GT(w.way, 0.0) << w.begin;
  const std::vector<SessionWindow> barely = session_windows(s, 0.5);
  EXPECT_THAT(barely, SizeIs(session_windows(s).size()));
  for (const SessionWindow& w : barely) EXPECT_TRUE(std::isnan(w.way)) << w.begin;
}

TEST(SessionWindows, WhatStandsIsSlowerThanAnyCarAndThanATwentiethOfItsDriving) {
  EXPECT_EQ(slowest_driving(20.0), 1.0);
  EXPECT_EQ(slowest_driving(1.0), standing_speed);
  std::vector<double> speeds(200, 5.0);
  speeds[7] = speeds[50] = 500.0;
  EXPECT_EQ(top_speed(speeds), 5.0) << "two wrong readings";
  EXPECT_EQ(top_speed({}), 0.0);
}

/// A mean is one of half of the rows at least.
TEST(SessionWindows, OfAChannelThatWasNotReadNothingIsShown) {
  Session s = circling(0.02, 10.0);
  for (std::size_t k = 0; k < s.rows(); ++k)
    if (!(s.t[k] < 2.0 - 1e-9)) reading(s, k, Channel::vx) = NAN;
  const std::vector<SessionWindow> windows = session_windows(s);
  ASSERT_FALSE(windows.empty());
  EXPECT_LT(windows.front().begin, 1.0);
  EXPECT_GT(windows.back().begin, 3.0);
  for (const SessionWindow& w : windows) {
    const bool read = w.begin + 0.25 < 2.0;
    EXPECT_EQ(std::isnan(w.speed), !read) << w.begin;
    EXPECT_EQ(std::isnan(w.gain), !(w.begin + 0.5 < 2.0)) << w.begin;
    EXPECT_DOUBLE_EQ(speed_of(w), read ? w.speed : w.way / w.seconds) << "else the place tells it";
  }
}

TEST(SessionWindows, SpeedOverPathIsTheScaleOfVx) {
  Session s = circling(0.02, 10.0);
  EXPECT_NEAR(speed_over_path(session_windows(s)), 1.0, 0.01);
  for (std::size_t k = 0; k < s.rows(); ++k) reading(s, k, Channel::vx) *= 3.6;
  EXPECT_NEAR(speed_over_path(session_windows(s)), 3.6, 0.01);
  EXPECT_TRUE(std::isnan(speed_over_path(session_windows(circling(0.02, 2.0))))) << "too few windows";
}

/// Swapped axes leave vx what the car slides; in a wrong unit vx is too large, or so small that vy is smaller yet.
TEST(SessionWindows, VelocitiesLookSwappedWhereVxIsSmallAndVyIsTheSpeed) {
  EXPECT_TRUE(velocities_look_swapped(0.0, 1.0));
  EXPECT_TRUE(velocities_look_swapped(-0.3, -0.95));
  EXPECT_FALSE(velocities_look_swapped(3.6, 1.0)) << "km/h of a car that slides";
  EXPECT_FALSE(velocities_look_swapped(1.0, 0.7));
  EXPECT_FALSE(velocities_look_swapped(0.28, 0.0));
  EXPECT_FALSE(velocities_look_swapped(NAN, 1.0));
  EXPECT_FALSE(velocities_look_swapped(0.0, NAN));
}

/// A car that comes to rest after ten seconds; its receiver goes on to show a few centimetres per second.
Session coming_to_rest(double seconds) {
  Session s = circling(0.02, seconds);
  for (std::size_t k = 500; k < s.rows(); ++k) {
    for (const std::size_t c : {Channel::x, Channel::y, Channel::yaw}) reading(s, k, c) = reading(s, 500, c);
    reading(s, k, Channel::vx) = 0.05;
  }
  return s;
}

TEST(SessionWindows, RowsOfACarAtRestDoNotMove) {
  Session s = coming_to_rest(20.0);
  const std::vector<bool> moving = moving_rows(s);
  const Session driven = while_moving(s);
  ASSERT_THAT(moving, SizeIs(s.rows()));
  for (std::size_t k = 0; k < s.rows(); ++k)
    if (std::abs(s.t[k] - 10.0) > 0.6) {
      EXPECT_EQ(moving[k], s.t[k] < 10.0) << s.t[k];
      EXPECT_EQ(std::isnan(driven.at(k, Channel::vx)), s.t[k] > 10.0) << s.t[k];
    }
  for (std::size_t k = 0; k < s.rows(); ++k) reading(s, k, Channel::vx) = 0.05;
  EXPECT_THAT(moving_rows(s), testing::Each(true)) << "a car that is always at rest: nothing to tell apart";
}

TEST(SessionWindows, TypicalSpeedComesFromTheSpeedOrThePlace) {
  Session s = circling(0.05, 20.0);
  EXPECT_NEAR(typical_speed(s), 10.0, 1e-9);
  for (std::size_t k = 0; k < s.rows(); ++k) reading(s, k, Channel::vx) = NAN;
  EXPECT_NEAR(typical_speed(s), 10.0, 0.2);
}

/// Of a log that is nine tenths of standing it is the speed of the tenth in which the car drives.
TEST(SessionWindows, TypicalSpeedIsThatOfACarThatMoves) {
  const Session s = coming_to_rest(100.0);
  EXPECT_NEAR(typical_speed(s), 10.0, 1e-9);
}

TEST(SessionWindows, TypicalSpeedOfNothingIsOne) {
  EXPECT_EQ(typical_speed({}), 1.0);
  Session s = circling(0.05, 20.0);
  s.reading.assign(s.reading.size(), NAN);
  EXPECT_EQ(typical_speed(s), 1.0);
}

TEST(SessionWindows, CorrelationsNeedTwentyValuesThatVary) {
  Correlation line, flat;
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(std::isnan(line.value())) << i;
    line.add(0.1 * i, 3.0 - 0.2 * i), flat.add(0.1, 0.2 * i);
  }
  EXPECT_NEAR(line.value(), -1.0, 1e-12);
  EXPECT_TRUE(std::isnan(flat.value()));
}

/// Steering that weaves, of a car that follows it, as the yaw rate shows or, without one, the heading.
TEST(SessionWindows, TurningIsComparedWithSteeringWhereTheCarDrives) {
  Session s = circling(0.02, 20.0);
  for (std::size_t k = 0; k < s.rows(); ++k) {
    s.command[k].delta = 0.1 * std::sin(s.t[k]);
    reading(s, k, Channel::yaw_rate) = -2.0 * s.command[k].delta;
    reading(s, k, Channel::yaw) = 0.2 * std::cos(s.t[k]);
  }
  const Correlation by_rate = turning_correlation(session_windows(s), 2.0);
  EXPECT_NEAR(by_rate.value(), -1.0, 1e-6);
  EXPECT_NEAR(seconds_of_windows(by_rate), 20.0, 1.0) << "windows overlap by half";
  for (std::size_t k = 0; k < s.rows(); ++k) reading(s, k, Channel::yaw_rate) = NAN;
  EXPECT_NEAR(turning_correlation(session_windows(s), 2.0).value(), -1.0, 1e-3);
  EXPECT_EQ(turning_correlation(session_windows(s), 20.0).n, 0.0) << "slower than that";
}

}  // namespace test_session_windows
}  // namespace gripline::measured
