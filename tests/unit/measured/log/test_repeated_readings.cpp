#include "measured/log/repeated_readings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <random>

#include "util/numbers.hpp"

namespace gripline::measured {
namespace test_repeated_readings {

using ::testing::HasSubstr;

constexpr double dt = 0.02, slowest = 2.0;
constexpr std::initializer_list<std::size_t> places{Channel::x, Channel::y};

class RepeatedReadings : public testing::Test {
 protected:
  /// A car that winds along at 10 m/s for a minute, read with noise.
  RepeatedReadings() {
    std::mt19937 random(7);
    std::normal_distribution<double> noise(0.0, 1.0);
    const Channels sigma{0.05, 0.05, 0.005, 0.05, 0.03, 0.01};
    double x = 0.0, y = 0.0;
    for (std::size_t i = 0; i < 3000; ++i) {
      const double t = dt * static_cast<double>(i), yaw = std::sin(0.5 * t), v = 10.0 + 2.0 * std::sin(0.3 * t);
      const Channels truth{x, y, yaw, v, 0.3 * std::cos(0.5 * t), 0.5 * std::cos(0.5 * t)};
      raw_.t.push_back(t);
      raw_.d.push_back(0.3 * std::cos(0.3 * t));
      raw_.delta.push_back(0.1 * std::cos(0.5 * t));
      raw_.row.push_back(i);
      for (std::size_t c = 0; c < channels; ++c) raw_.reading.push_back(truth[c] + sigma[c] * noise(random));
      x += v * std::cos(yaw) * dt;
      y += v * std::sin(yaw) * dt;
    }
  }

  void hold(std::size_t c, std::size_t rows) {
    for (std::size_t i = 0; i < raw_.size(); ++i) raw_.at(i, c) = raw_.at(i - i % rows, c);
  }
  void round_to(std::size_t c, double step) {
    for (std::size_t i = 0; i < raw_.size(); ++i) raw_.at(i, c) = step * std::round(raw_.at(i, c) / step);
  }
  /// From one row to before another each is as in the first.
  void stand(std::size_t c, std::size_t first, std::size_t end) {
    for (std::size_t i = first + 1; i < end; ++i) raw_.at(i, c) = raw_.at(first, c);
  }
  std::size_t missing(std::size_t c) const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < raw_.size(); ++i) count += std::isnan(raw_.at(i, c)) ? 1 : 0;
    return count;
  }
  std::size_t missing() const {
    std::size_t count = 0;
    for (std::size_t c = 0; c < channels; ++c) count += missing(c);
    return count;
  }
  void leave_out() {
    leave_out_constant_lateral_speed(raw_, health_);
    leave_out_standing(raw_, slowest, health_);
    leave_out_repeats(raw_, dt, slowest, health_);
  }

  RawLog raw_;
  std::vector<Finding> health_;
};

TEST_F(RepeatedReadings, WhatIsReadInEveryRowStays) {
  leave_out();
  EXPECT_TRUE(health_.empty());
  EXPECT_EQ(missing(), 0u);
}

TEST_F(RepeatedReadings, HeldValuesAreReadOnce) {
  const RawLog before = raw_;
  for (const std::size_t c : places) hold(c, 5);
  hold(Channel::yaw_rate, 2);
  leave_out();
  EXPECT_EQ(missing(Channel::x), 2400u);
  EXPECT_EQ(missing(Channel::yaw_rate), 1500u);
  EXPECT_EQ(missing(Channel::yaw), 0u);
  for (std::size_t i = 0; i < raw_.size(); i += 5) EXPECT_EQ(raw_.at(i, Channel::y), before.at(i, Channel::y)) << i;
  ASSERT_EQ(health_.size(), 2u);
  EXPECT_EQ(health_[1].check, "x, y");
  EXPECT_EQ(health_[1].found, "a new value every 5 rows");
  EXPECT_EQ(health_[0].check, "yaw_rate");
  EXPECT_EQ(health_[0].found, "a new value every 2 rows");
}

TEST_F(RepeatedReadings, ASensorsOwnClockIsAPaceToo) {
  for (std::size_t i = 0, last = 0; i < raw_.size(); ++i) {
    if (static_cast<std::size_t>(static_cast<double>(i) / 2.5) >
        static_cast<std::size_t>(static_cast<double>(last) / 2.5))
      last = i;
    raw_.at(i, Channel::x) = raw_.at(last, Channel::x);
  }
  leave_out();
  EXPECT_NEAR(static_cast<double>(missing(Channel::x)), 1800.0, 5.0);
}

TEST_F(RepeatedReadings, CoarseReadingsStay) {
  for (const double times : {1.0, 3.0, 10.0}) {
    const RawLog before = raw_;
    const Channels steps{0.05, 0.05, 0.01, 0.05, 0.05, 0.01};
    for (std::size_t c = 0; c < channels; ++c) round_to(c, times * steps[c]);
    leave_out();
    EXPECT_TRUE(health_.empty()) << times;
    EXPECT_EQ(missing(), 0u) << times;
    raw_ = before;
  }
}

/// Where rounding makes some new values the same as the last one, changes come after whole multiples of the pace.
TEST_F(RepeatedReadings, CoarseReadingsThatAreHeldAreReadOnce) {
  hold(Channel::vx, 5);
  round_to(Channel::vx, 0.1);
  leave_out();
  EXPECT_GE(missing(Channel::vx), 2400u);
}

TEST_F(RepeatedReadings, EmptyCellsAreNoRepeats) {
  for (std::size_t i = 0; i < raw_.size(); ++i)
    if (i % 5 != 0) raw_.at(i, Channel::x) = not_a_number;
  leave_out();
  EXPECT_TRUE(health_.empty());
  EXPECT_EQ(missing(), 2400u);
}

TEST_F(RepeatedReadings, APlaceThatStandsWhileTheCarMovesIsNotRead) {
  for (const std::size_t c : places) stand(c, 1000, 1150);
  leave_out();
  EXPECT_EQ(missing(Channel::x), 149u);
  EXPECT_EQ(missing(Channel::y), 149u);
  EXPECT_FALSE(std::isnan(raw_.at(1000, Channel::x)));
  ASSERT_EQ(health_.size(), 1u);
  EXPECT_EQ(health_[0].check, "x, y");
  EXPECT_EQ(health_[0].found, "stand still from 20 s to 22.98 s while the car moves");
}

TEST_F(RepeatedReadings, APlaceThatStandsIsFoundAmongHeldOnes) {
  for (const std::size_t c : places) {
    hold(c, 5);
    stand(c, 1000, 1150);
  }
  leave_out();
  ASSERT_EQ(health_.size(), 2u);
  EXPECT_THAT(health_[0].found, HasSubstr("stand still from 20 s"));
  EXPECT_THAT(health_[1].found, HasSubstr("every 5 rows"));
  for (std::size_t i = 1001; i < 1150; ++i) EXPECT_TRUE(std::isnan(raw_.at(i, Channel::x))) << i;
}

TEST_F(RepeatedReadings, EveryChannelThatStandsIsNotRead) {
  for (std::size_t c = 0; c < channels; ++c) stand(c, 1000, 1075);
  leave_out();
  EXPECT_EQ(raw_.size(), 3000u);
  EXPECT_EQ(missing(), 6u * 74u);
  ASSERT_EQ(health_.size(), 1u);
  EXPECT_EQ(health_[0].check, "x, y, yaw, vx, vy, yaw_rate");
}

TEST_F(RepeatedReadings, RowsInWhichCommandsStandAsWellGo) {
  for (std::size_t c = 0; c < channels; ++c) stand(c, 1000, 1075);
  for (std::size_t i = 1001; i < 1075; ++i) {
    raw_.d[i] = raw_.d[1000];
    raw_.delta[i] = raw_.delta[1000];
  }
  leave_out();
  EXPECT_EQ(raw_.size(), 3000u - 74u);
  EXPECT_EQ(missing(), 0u);
}

TEST_F(RepeatedReadings, ACarThatStandsIsRead) {
  for (std::size_t i = 1000; i < 1500; ++i)
    for (std::size_t c = 0; c < channels; ++c) raw_.at(i, c) = c < Channel::vx ? raw_.at(1000, c) : 0.0;
  leave_out();
  EXPECT_TRUE(health_.empty());
  EXPECT_EQ(missing(), 0u);
}

/// Without noise, straight on along the axis: what does not change had no reason to.
TEST_F(RepeatedReadings, AStraightWithoutNoiseIsRead) {
  double x = 0.0, y = 0.0;
  for (std::size_t i = 0; i < raw_.size(); ++i) {
    const double t = raw_.t[i], turning = std::max(0.0, t - 20.0);
    const double rate = 0.1 * std::sin(0.5 * turning), yaw = 0.2 * (1.0 - std::cos(0.5 * turning));
    const double v = 10.0 + 2.0 * std::sin(0.3 * t);
    const Channels truth{x, y, yaw, v, 0.1 * rate, rate};
    for (std::size_t c = 0; c < channels; ++c) raw_.at(i, c) = truth[c];
    x += v * std::cos(yaw) * dt;
    y += v * std::sin(yaw) * dt;
  }
  leave_out();
  EXPECT_TRUE(health_.empty());
  EXPECT_EQ(missing(), 0u);
}

TEST_F(RepeatedReadings, AConstantLateralSpeedOfACarThatTurnsIsNotRead) {
  for (std::size_t i = 0; i < raw_.size(); ++i) raw_.at(i, Channel::vy) = 0.0;
  leave_out();
  EXPECT_EQ(missing(Channel::vy), 3000u);
  ASSERT_EQ(health_.size(), 1u);
  EXPECT_EQ(health_[0].level, Finding::Level::bad);
  EXPECT_EQ(health_[0].check, "vy");
  EXPECT_THAT(health_[0].found, HasSubstr("is 0 in every row"));
}

}  // namespace test_repeated_readings
}  // namespace gripline::measured
