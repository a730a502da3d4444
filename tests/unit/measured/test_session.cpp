#include "measured/session.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gripline::measured {
namespace {

/// 100 Hz rows; the steering steps to `to` at 1.0 s and back at 1.05 s, the throttle at 2.0 s.
Session stepping() {
  Session s;
  for (int i = 0; i <= 300; ++i) {
    const double t = 0.01 * i;
    s.t.push_back(t);
    s.command.push_back({i >= 200 ? 0.5 : 0.0, i >= 100 && i < 105 ? 0.2 : 0.0});
  }
  return s;
}

double steering(const CommandGrid& grid, double t) {
  return grid.sample[static_cast<std::size_t>(std::lround(t / grid.dt))].delta;
}

TEST(CommandGrid, StepsStayStepsWhereEveryRowIsRead) {
  const CommandGrid grid(stepping(), 0.01);
  EXPECT_EQ(steering(grid, 0.99), 0.0);
  EXPECT_EQ(steering(grid, 1.0), 0.2);
}

TEST(CommandGrid, ACommandReadEverySoOftenMovesEvenlyToItsNextReading) {
  Session s = stepping();
  s.steering_every = 0.1;
  const CommandGrid grid(s, 0.01);
  EXPECT_EQ(steering(grid, 0.89), 0.0);
  EXPECT_NEAR(steering(grid, 0.95), 0.1, 1e-9);
  EXPECT_NEAR(steering(grid, 1.0), 0.2, 1e-9);
  EXPECT_NEAR(steering(grid, 1.03), 0.08, 1e-9);  // back within the 50 ms since that reading
  EXPECT_EQ(steering(grid, 1.06), 0.0);
  EXPECT_EQ(grid.sample[195].d, 0.0);  // read in every row
}

TEST(CommandGrid, AMovementIsKnownOnceItsEndWasRead) {
  Session s = stepping();
  s.throttle_every = 0.1;
  const CommandGrid grid(s, 0.01);
  EXPECT_EQ(grid.known(1.5), 151u);
  EXPECT_LE(grid.known(1.99), 191u);  // of 1.90 s on nothing is known before 2.0 s
  EXPECT_EQ(grid.known(2.0), 201u);
  for (std::size_t k = 1; k < grid.known_at.size(); ++k) EXPECT_GE(grid.known_at[k], grid.known_at[k - 1]);
}

TEST(CommandGrid, ACommandThatChangesMoreOftenThanItIsSaidToBeReadStaysAsItStands) {
  Session s = stepping();
  for (std::size_t i = 0; i < s.rows(); ++i)
    if (s.t[i] > 1.2 - 1e-9) s.command[i].delta = 0.01 * std::floor((s.t[i] + 1e-9) / 0.05);
  const CommandGrid as_written(s, 0.01);
  s.steering_every = 0.1;
  const CommandGrid grid(s, 0.01);
  EXPECT_NEAR(steering(grid, 0.95), 0.1, 1e-9);  // so far it is read as said
  for (double t = 1.45; t < 1.9; t += 0.01) EXPECT_EQ(steering(grid, t), steering(as_written, t)) << t;
}

}  // namespace
}  // namespace gripline::measured
