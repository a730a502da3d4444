#include "measured/session/centre_of_gravity.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace gripline::measured {
namespace test_centre_of_gravity {

constexpr double speed = 10.0, turning = 0.5;  // [m/s], [rad/s]

/// A car on a circle, without sideslip: its velocity as `unit` shows it, in rows 0.05 s apart.
SessionFile seen_by(const Frame& unit) {
  SessionFile file;
  Session& s = file.session;
  s.has.fill(true);
  s.velocity = unit;
  const double ahead = speed - unit.y * turning, left = unit.x * turning;
  const double c = std::cos(unit.yaw), sine = std::sin(unit.yaw);
  for (int k = 0; k < 200; ++k) {
    const double t = 0.05 * k, yaw = turning * t, radius = speed / turning;
    s.t.push_back(t);
    for (const double v : {radius * std::sin(yaw), -radius * std::cos(yaw), yaw, c * ahead + sine * left,
                           c * left - sine * ahead, turning})
      s.reading.push_back(v);
    s.command.push_back({0.1, 0.13});
  }
  file.row_step = 0.05;
  return file;
}

/// Leaves a channel's readings in every so many rows, from the first on.
void thin(Session& s, std::size_t channel, std::size_t every) {
  for (std::size_t i = 0; i < s.rows(); ++i)
    if (i % every != 0) s.reading[i * channels + channel] = NAN;
}

TEST(CentreOfGravity, AVelocityIsTakenThereAndTurnedBack) {
  const Session own = at_centre_of_gravity(seen_by({0.3, 0.7, 0.4, true, true, true}));
  for (std::size_t i = 0; i < own.rows(); ++i) {
    ASSERT_NEAR(own.at(i, Channel::vx), speed, 1e-12) << i;
    ASSERT_NEAR(own.at(i, Channel::vy), 0.0, 1e-12) << i;
  }
  EXPECT_FALSE(own.velocity.given());
}

/// As of a gyroscope at 5 Hz beside velocities in every row: all of them are of one point.
TEST(CentreOfGravity, AYawRateOfRowsAroundTakesTheLeverOff) {
  SessionFile file = seen_by({0.3, 0.7, 0.0, true, true, false});
  thin(file.session, Channel::yaw_rate, 4);
  const Session own = at_centre_of_gravity(file);
  for (std::size_t i = 0; i <= 196; ++i) {
    ASSERT_NEAR(own.at(i, Channel::vx), speed, 1e-12) << i;
    ASSERT_NEAR(own.at(i, Channel::vy), 0.0, 1e-12) << i;
    ASSERT_EQ(std::isnan(own.at(i, Channel::yaw_rate)), i % 4 != 0) << i;
  }
}

TEST(CentreOfGravity, ASpeedIsTurnedBackByTheLateralOneOfRowsAround) {
  SessionFile file = seen_by({0.0, 0.0, 0.4, false, false, true});
  thin(file.session, Channel::vy, 4);
  const Session own = at_centre_of_gravity(file);
  for (std::size_t i = 0; i <= 196; ++i) {
    ASSERT_NEAR(own.at(i, Channel::vx), speed, 1e-12) << i;
    ASSERT_EQ(std::isnan(own.at(i, Channel::vy)), i % 4 != 0) << i;
  }
}

/// A unit that looks backwards shows a car that drives forwards as one that does not.
TEST(CentreOfGravity, OfASpeedAloneTheCarIsTakenToMoveStraightAhead) {
  for (const double turned : {std::numbers::pi, 0.4}) {
    SessionFile file = seen_by({0.0, 0.0, turned, false, false, true});
    file.session.has[Channel::vy] = false;
    for (std::size_t i = 0; i < file.session.rows(); ++i) file.session.reading[i * channels + Channel::vy] = NAN;
    const Session own = at_centre_of_gravity(file);
    for (std::size_t i = 0; i < own.rows(); ++i) {
      ASSERT_NEAR(own.at(i, Channel::vx), speed, 1e-12) << i;
      ASSERT_TRUE(std::isnan(own.at(i, Channel::vy))) << i;
    }
  }
}

}  // namespace test_centre_of_gravity
}  // namespace gripline::measured
