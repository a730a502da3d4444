#include "measured/replay/trace.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "measured/log/log.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {
namespace test_trace {

/// Channel c is a quadratic of time, so that local quadratics reproduce it.
Log quadratic(std::size_t n) {
  Log log;
  log.command.resize(n);
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t c = 0; c < channels; ++c) {
      const double t = static_cast<double>(k);
      log.reading.push_back(static_cast<double>(c) + 0.3 * t - 0.01 * t * t);
    }
  return log;
}

TEST(SmoothReadings, ReproduceAQuadraticAlsoWhereReadingsAreMissing) {
  const Log whole = quadratic(40);
  Log holes = whole;
  for (std::size_t k = 10; k < 22; ++k) holes.reading[k * channels + 2] = not_a_number;
  for (const Log& log : {whole, holes}) {
    const std::vector<double> smooth = smooth_readings(log, 3);
    ASSERT_EQ(smooth.size(), whole.reading.size());
    for (std::size_t i = 0; i < smooth.size(); ++i) EXPECT_NEAR(smooth[i], whole.reading[i], 1e-6) << i;
  }
}

TEST(SmoothReadings, AChannelThatWasNeverReadIsZero) {
  Log log = quadratic(20);
  for (std::size_t k = 0; k < 20; ++k) log.reading[k * channels + 4] = not_a_number;
  const std::vector<double> smooth = smooth_readings(log, 3);
  for (std::size_t k = 0; k < 20; ++k) EXPECT_EQ(smooth[k * channels + 4], 0.0);
}

/// Ten minutes at 100 Hz without vy_mps.
TEST(SmoothReadings, AnAbsentChannelOfALongLogIsZero) {
  Log log = quadratic(60000);
  for (std::size_t k = 0; k < log.size(); ++k) log.reading[k * channels + 4] = not_a_number;
  const std::vector<double> smooth = smooth_readings(log, 3);
  EXPECT_EQ(smooth[30000 * channels + 4], 0.0);
  EXPECT_NEAR(smooth[30000 * channels + 3], log.reading[30000 * channels + 3], 1e-3);
}

/// A trace that is not as long gets no rows that nobody measured.
TEST(Trace, IsCutAndNeverLengthened) {
  Trace trace;
  trace.log = quadratic(20);
  trace.motion = trace.log.reading;
  trace.at.resize(20);
  const std::vector<double> readings = trace.log.reading;
  trace.cut(50);
  EXPECT_EQ(trace.size(), 20U);
  EXPECT_EQ(trace.log.reading, readings);
  EXPECT_EQ(trace.at.size(), 20U);
  trace.cut(8);
  EXPECT_EQ(trace.size(), 8U);
  EXPECT_EQ(trace.motion, std::vector<double>(readings.begin(), readings.begin() + 8 * channels));
  EXPECT_EQ(trace.command_dual.size(), 8U);
}

TEST(Trace, PlacesBetweenSamplesGoTheShortWayRoundTheLap) {
  Place from, to;
  from.t = 1.0;
  from.lap_fraction = 0.98;
  to.lap_fraction = 0.02;
  EXPECT_NEAR(between(from, to, 0.25, 0.02).lap_fraction, 0.99, 1e-12);
  EXPECT_NEAR(between(from, to, 0.75, 0.02).lap_fraction, 0.01, 1e-12);
  EXPECT_NEAR(between(from, to, 0.75, 0.02).t, 1.015, 1e-12);
}

TEST(Log, CommandsAreLinearBetweenSamples) {
  Log log = quadratic(3);
  log.dt = 0.5;
  log.command = {{0.0, 0.1}, {1.0, 0.2}, {0.0, 0.2}};
  const auto u = command_at(log, 0, 0.25);
  EXPECT_DOUBLE_EQ(u.d, 0.25);
  EXPECT_DOUBLE_EQ(u.delta, 0.125);
  EXPECT_DOUBLE_EQ(u.delta_rate, 0.2);
  EXPECT_DOUBLE_EQ(command_at(log, 2, 0.5).d, 0.0) << "held after the last sample";
  EXPECT_FALSE(log.interpolated_step(0));
  log.interpolated = {false, false, true};
  EXPECT_FALSE(log.interpolated_step(0));
  EXPECT_TRUE(log.interpolated_step(1));
}

/// Nothing can have been left out where a command rests; a jump counts by its size and as it begins and ends.
TEST(Log, VariationIsWhereCommandsMove) {
  Log log = quadratic(6);
  log.command = {{0.5, 0.0}, {0.5, 0.1}, {0.5, 0.2}, {0.5, 0.3}, {0.9, 0.4}, {0.9, 0.5}};
  const std::vector<Commands> variation = command_variation(log);
  ASSERT_EQ(variation.size(), 5U);
  EXPECT_DOUBLE_EQ(variation[1][0], 0.0);
  EXPECT_NEAR(variation[1][1], 0.1, 1e-12) << "a straight line";
  EXPECT_NEAR(variation[3][0], 0.4 * std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(variation[2][0], 0.4 * std::sqrt(0.5), 1e-12);
}

/// A parabola through the samples is bent by an eighth of its second difference.
TEST(Log, BentCommandsFollowAParabola) {
  Log log = quadratic(5);
  log.dt = 0.5;
  log.command.clear();
  for (const double t : {0.0, 1.0, 2.0, 3.0, 4.0}) log.command.push_back({t * t, -0.1 * t * t});
  EXPECT_DOUBLE_EQ(command_curvature({&log, 1})[0], 2.0);
  bend_commands(log, {-0.125, -0.125});
  ASSERT_EQ(log.fine.size(), 9U);
  const auto middle = command_at(log, 1, 0.5), quarter = command_at(log, 1, 0.25);
  EXPECT_DOUBLE_EQ(middle.d, 1.5 * 1.5);
  EXPECT_DOUBLE_EQ(middle.delta, -0.1 * 1.5 * 1.5);
  EXPECT_DOUBLE_EQ(quarter.d, 0.5 * (1.0 + 2.25)) << "straight between the fine ones";
  EXPECT_DOUBLE_EQ(quarter.delta_rate, -0.1 * 1.25 / 0.25);
  EXPECT_DOUBLE_EQ(command_at(log, 4, 0.0).d, 16.0);
  EXPECT_DOUBLE_EQ(history_at(log, 2.0).at(1.25).d, 2.25);
  bend_commands(log, {});
  EXPECT_TRUE(log.fine.empty());
}

}  // namespace test_trace
}  // namespace gripline::measured
