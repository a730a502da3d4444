#include "measured/session/session.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "util/numbers.hpp"

namespace gripline::measured {
namespace test_session {

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

BetweenRows read_every(double seconds) { return {.used = BetweenRows::Kind::paced, .every = seconds}; }

/// Rows on the grid: linear between samples, what is held until the next row must not come half a sample early.
TEST(CommandGrid, AHeldCommandHasItsMeanOverEveryStretch) {
  Session s = stepping();  // rows 10 ms apart, the steering steps to 0.2 at 1.0 s
  s.steering_between.used = BetweenRows::Kind::held;
  const CommandGrid grid(s, 0.01);
  EXPECT_EQ(steering(grid, 0.99), 0.0);
  EXPECT_NEAR(steering(grid, 1.0), 0.1, 1e-9);
  EXPECT_NEAR(steering(grid, 1.01), 0.2, 1e-9);
  EXPECT_EQ(grid.row_at[100], s.t[100]);  // nothing of later rows is in it
  const CommandGrid fine(s, 0.0025);
  EXPECT_EQ(steering(fine, 0.9975), 0.0);
  EXPECT_NEAR(steering(fine, 1.0025), 0.2, 1e-9);
}

/// A channel at 4 Hz in rows of 20 Hz: 0.55 - 0.3 is a little more than 0.25.
TEST(Session, StampsThatAreRoundedMakeNoGap) {
  Session s;
  for (int i = 0; i <= 200; ++i) {
    s.t.push_back(0.05 * i);
    s.reading.resize(s.t.size() * channels, not_a_number);
    if (i % 5 == 1) s.reading[static_cast<std::size_t>(i) * channels + Channel::vx] = 2.0 * s.t.back();
  }
  for (double time = 0.06; time < 9.8; time += 0.05)
    EXPECT_NEAR(s.bridge(Channel::vx, time, INFINITY, even_motion).value, 2.0 * time, 1e-9) << time;
}

/// Rows at 4 Hz: none of their commands is held.
TEST(CommandGrid, RowsAsFarApartAsACarMovesEvenlyHaveLinesBetweenThem) {
  Session s;
  for (int i = 0; i <= 40; ++i) {
    s.t.push_back(0.05 * (1 + 5 * i));
    s.command.push_back({s.t.back(), 0.0});
  }
  const CommandGrid grid(s, 0.05);
  for (std::size_t k = 0; k < grid.sample.size(); ++k)
    EXPECT_NEAR(grid.sample[k].d, grid.t0 + grid.dt * static_cast<double>(k), 1e-9) << k;
}

TEST(CommandGrid, ACommandReadEverySoOftenMovesEvenlyToItsNextReading) {
  Session s = stepping();
  s.steering_between = read_every(0.1);
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
  s.throttle_between = read_every(0.1);
  const CommandGrid grid(s, 0.01);
  EXPECT_EQ(grid.known(1.5), 151u);
  EXPECT_LE(grid.known(1.99), 191u);  // of 1.90 s on nothing is known before 2.0 s
  EXPECT_EQ(grid.known(2.0), 201u);
  for (std::size_t k = 1; k < grid.known_at.size(); ++k) EXPECT_GE(grid.known_at[k], grid.known_at[k - 1]);
}

TEST(CommandGrid, UntilItsNextReadingACommandIsHeldWhateverTheOtherOneDoes) {
  Session s = stepping();  // the throttle steps at 2.0 s
  for (std::size_t i = 205; i < s.rows(); ++i) s.command[i].delta = 0.3;
  s.steering_between = read_every(0.1);
  const CommandGrid grid(s, 0.01);
  EXPECT_EQ(grid.shown_by(2.0), 201u);
  EXPECT_LT(grid.known(2.0), 201u);  // the steering moves from 1.95 s to 2.05 s
  std::vector<CommandSample<double>> shown;
  grid.copy_shown(2.0, s.command[200], 150, shown);
  ASSERT_EQ(shown.size(), 51u);
  EXPECT_EQ(shown.back().d, 0.5);
  for (const auto& c : shown) EXPECT_EQ(c.delta, 0.0);
  grid.copy_shown(2.05, s.command[205], 150, shown);
  EXPECT_EQ(shown.back().delta, 0.3);
  EXPECT_NEAR(shown[50].delta, 0.15, 1e-9);
}

TEST(Session, ReadingsAreBridgedAsFarAsTheyAreKnown) {
  Session s = stepping();
  s.reading.assign(s.rows() * channels, not_a_number);
  for (std::size_t i = 0; i < s.rows(); i += 10) s.reading[i * channels + 3] = 0.1 * static_cast<double>(i);
  EXPECT_TRUE(std::isnan(s.interpolate(3, 1.05)));
  EXPECT_NEAR(s.bridge(3, 1.05, 2.0, 0.5).value, 10.5, 1e-9);
  EXPECT_NEAR(s.bridge(3, 1.05, 2.0, 0.5).slope, 10.0, 1e-9);
  EXPECT_NEAR(s.bridge(3, 1.05, 1.09, 0.5).value, 10.0, 1e-9);  // the next one is not known yet
  EXPECT_EQ(s.bridge(3, 1.05, 1.09, 0.5).slope, 0.0);
  EXPECT_NEAR(s.bridge(3, 1.1, 1.1, 0.5).value, 11.0, 1e-9);
  EXPECT_TRUE(std::isnan(s.bridge(3, 1.05, 2.0, 0.04).value));
  EXPECT_NEAR(s.bridge(3, 3.4, 9.0, 0.5).value, 30.0, 1e-9);
  EXPECT_TRUE(std::isnan(s.bridge(3, 4.0, 9.0, 0.5).value));
}

TEST(CommandGrid, ACommandThatChangesMoreOftenThanItIsSaidToBeReadStaysAsItStands) {
  Session s = stepping();
  for (std::size_t i = 0; i < s.rows(); ++i)
    if (s.t[i] > 1.2 - 1e-9) s.command[i].delta = 0.01 * std::floor((s.t[i] + 1e-9) / 0.05);
  const CommandGrid as_written(s, 0.01);
  s.steering_between = read_every(0.1);
  const CommandGrid grid(s, 0.01);
  EXPECT_NEAR(steering(grid, 0.95), 0.1, 1e-9);  // so far it is read as said
  for (double t = 1.45; t < 1.9; t += 0.01) EXPECT_EQ(steering(grid, t), steering(as_written, t)) << t;
}

}  // namespace test_session
}  // namespace gripline::measured
