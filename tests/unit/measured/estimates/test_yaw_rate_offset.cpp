#include "measured/estimates/yaw_rate_offset.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "util/numbers.hpp"

namespace gripline::measured {
namespace test_yaw_rate_offset {

constexpr std::size_t yaw_channel = 2, rate_channel = 5;

double true_rate(double t) { return 0.6 * std::sin(0.7 * t) + 0.9 * std::sin(2.3 * t + 1.0) + 0.4; }
double true_yaw(double t) { return -0.6 / 0.7 * std::cos(0.7 * t) - 0.9 / 2.3 * std::cos(2.3 * t + 1.0) + 0.4 * t; }

/// A car that turns left and right, mostly left, for so long; its yaw rate shows `offset` too much.
Session turning(double offset, double seconds, double dt = 0.01) {
  Session s;
  s.has.fill(true);
  for (std::size_t k = 0; k < static_cast<std::size_t>(seconds / dt); ++k) {
    const double t = static_cast<double>(k) * dt;
    s.t.push_back(t);
    const std::array<double, channels> row{0.0, 0.0, true_yaw(t), 2.0, 0.0, true_rate(t) + offset};
    s.reading.insert(s.reading.end(), row.begin(), row.end());
    s.command.push_back({0.3, 0.0});
  }
  return s;
}

double& reading(Session& s, std::size_t row, std::size_t channel) { return s.reading[row * channels + channel]; }

std::optional<YawRateOffset> offset_of(const Session& session) {
  const Session* const one = &session;
  return yaw_rate_offset({&one, 1});
}

void add_noise(Session& s, unsigned seed, double of_yaw, double of_rate) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (std::size_t row = 0; row < s.rows(); ++row) {
    reading(s, row, yaw_channel) += of_yaw * normal(random);
    reading(s, row, rate_channel) += of_rate * normal(random);
  }
}

TEST(YawRateOffset, IsFoundExactlyWhereNothingIsNoisy) {
  for (const double offset : {0.0, -0.11, 0.02}) {
    const auto found = offset_of(turning(offset, 60.0));
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->value, offset, 1e-5);  // of trapezia
    EXPECT_LT(found->sigma, 1e-5);
    EXPECT_EQ(found->parts, 6u);
    EXPECT_LT(found->range().first, offset + 1e-6);
    EXPECT_GT(found->range().second, offset - 1e-6);
  }
}

/// The standard error is that of many such logs, or larger, since stretches adjoin.
TEST(YawRateOffset, KnowsHowFarOffNoiseMakesIt) {
  double square = 0.0, told = 0.0;
  std::size_t inside = 0;
  constexpr unsigned logs = 60;
  for (unsigned seed = 1; seed <= logs; ++seed) {
    Session s = turning(0.03, 80.0, 0.02);
    add_noise(s, seed, 0.002, 0.1);
    const auto found = offset_of(s);
    ASSERT_TRUE(found);
    square += (found->value - 0.03) * (found->value - 0.03);
    told += found->sigma * found->sigma;
    inside += found->range().first < 0.03 && found->range().second > 0.03;
  }
  // 0.1 rad/s at 4000 readings.
  EXPECT_NEAR(std::sqrt(square / logs), 0.1 / std::sqrt(4000.0), 0.3 * 0.1 / std::sqrt(4000.0));
  EXPECT_GT(told, 0.8 * square);
  EXPECT_LT(told, 1.6 * square);
  EXPECT_GE(inside, logs - 1);
}

TEST(YawRateOffset, GapsAndReadingsThatAreMissingDoNotCount) {
  Session s = turning(0.05, 60.0);
  for (std::size_t row = 1000; row < 1700; ++row) reading(s, row, yaw_channel) = not_a_number;
  for (std::size_t row = 2500; row < 3100; ++row) reading(s, row, rate_channel) = not_a_number;
  for (std::size_t row = 0; row < s.rows(); row += 3) reading(s, row, rate_channel) = not_a_number;
  for (std::size_t row = 0; row < s.rows(); ++row)
    if (row % 10 != 0) reading(s, row, yaw_channel) = not_a_number;  // ten yaws a second
  const auto found = offset_of(s);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->value, 0.05, 2e-4);
  EXPECT_EQ(found->parts, 5u);

  Session cut = turning(0.05, 60.0);  // rows are missing, of a car that goes on turning
  for (std::size_t row = 3000; row < cut.rows(); ++row) {
    cut.t[row] += 25.0;
    reading(cut, row, yaw_channel) = true_yaw(cut.t[row]);
    reading(cut, row, rate_channel) = true_rate(cut.t[row]) + 0.05;
  }
  EXPECT_NEAR(offset_of(cut)->value, 0.05, 1e-5);
}

TEST(YawRateOffset, YawMayBeWrappedOrItsFrameTurned) {
  Session wrapped = turning(-0.02, 60.0), turned = wrapped;
  for (std::size_t row = 0; row < wrapped.rows(); ++row) {
    double& yaw = reading(wrapped, row, yaw_channel);
    yaw = std::remainder(yaw, 2.0 * std::numbers::pi);
    if (row > 2222) reading(turned, row, yaw_channel) += 1.3;
  }
  for (std::size_t row : {500u, 1500u, 4000u}) reading(turned, row, yaw_channel) -= 0.7;  // wild readings
  EXPECT_NEAR(offset_of(wrapped)->value, -0.02, 1e-5);
  EXPECT_NEAR(offset_of(turned)->value, -0.02, 1e-5);
}

TEST(YawRateOffset, LogsCountTogetherByTheirTime) {
  Session longer = turning(0.02, 60.0), other = turning(0.05, 30.0);
  const std::array<const Session*, 2> both{&longer, &other};
  const auto found = yaw_rate_offset(both);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->value, 0.03, 1e-4);
  EXPECT_EQ(found->parts, 9u);
  // Of six stretches S - 0.03 T is -0.1 rad, of three 0.2 rad; two logs say little of how logs differ.
  EXPECT_NEAR(found->sigma, std::sqrt((6.0 * 0.1 * 0.1 + 3.0 * 0.2 * 0.2) * 9.0 / 8.0) / 90.0, 1e-5);
}

/// Of each log S - 0.035 T is 0.45 rad, which the spread over stretches makes half of.
TEST(YawRateOffset, LogsThatDifferAreAsManyAsTheyAre) {
  const Session low = turning(0.02, 30.0), high = turning(0.05, 30.0);
  const auto found = yaw_rate_offset(std::array{&low, &high, &low, &high});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->parts, 4u);
  EXPECT_NEAR(found->sigma, std::sqrt(4.0 * 0.45 * 0.45 * 4.0 / 3.0) / 120.0, 1e-5);
  EXPECT_NEAR(found->range().second - found->value, 9.219 * found->sigma, 0.01 * found->sigma) << "t of 3 degrees";
  EXPECT_EQ(yaw_rate_offset(std::array{&low, &high, &low})->parts, 9u);
}

TEST(YawRateOffset, LogsThatAgreeAreAsSureAsTheirStretches) {
  Session one = turning(0.02, 60.0);  // whose offset differs from stretch to stretch, much the same in both logs
  for (std::size_t row = 0; row < one.rows(); ++row)
    reading(one, row, rate_channel) += 0.01 * std::sin(std::numbers::pi * one.t[row] / 10.0);
  const Session other = one;
  const std::array<const Session*, 2> both{&one, &other};
  EXPECT_NEAR(yaw_rate_offset(both)->sigma, offset_of(one)->sigma * std::sqrt(5.0 / 11.0), 1e-9);
  EXPECT_GT(offset_of(one)->sigma, 1e-3);
}

TEST(YawRateOffset, IsNotToldWhereYawOrYawRateIsMissingOrTheLogIsShort) {
  for (const std::size_t channel : {yaw_channel, rate_channel}) {
    Session s = turning(0.05, 60.0);
    s.has[channel] = false;
    for (std::size_t row = 0; row < s.rows(); ++row) reading(s, row, channel) = not_a_number;
    EXPECT_FALSE(offset_of(s));
  }
  EXPECT_FALSE(offset_of(turning(0.05, 14.0)));
  EXPECT_TRUE(offset_of(turning(0.05, 16.0)));
  const Session brief = turning(0.05, 4.5), half = turning(0.05, 6.0);
  EXPECT_FALSE(yaw_rate_offset(std::array{&brief, &brief, &brief}));
  EXPECT_TRUE(yaw_rate_offset(std::array{&half, &half}));
  EXPECT_FALSE(yaw_rate_offset({}));
}

/// Two stretches that differ say next to nothing.
TEST(YawRateOffset, IsKnownBadlyByFewStretches) {
  YawRateOffset few{0.0, 0.01, 2}, many{0.0, 0.01, 400};
  EXPECT_GT(few.range().second, 1.0);
  EXPECT_NEAR(many.range().second, 0.03, 0.001);
  EXPECT_NEAR(many.range().first, -many.range().second, 1e-12);
}

}  // namespace test_yaw_rate_offset
}  // namespace gripline::measured
