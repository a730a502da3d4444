#include "measured/displacement_lag.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace gripline::measured {
namespace test_displacement_lag {

constexpr double dt = 0.02;

/// A heavy car on a winding road as its channels show it.
struct Drive {
  double velocity_late = 0, place_late = 0;  // [s]
  double noise = 0.05;                       // of a place [m]
  double scale = 1, turned = 0, lever = 0;   // of the speeds, of their axes [rad], of the place [m]
  double speed_swing = 12;                   // [m/s]
};

struct Channels {
  std::vector<double> x, y, yaw, vx, vy;
  PlaneMotion motion() const { return {x, y, yaw, vx, vy, dt}; }
};

Channels channels_of(const Drive& drive) {
  constexpr int fine = 20, count = 3000;
  const auto yaw_at = [](double t) { return 1.5 * std::sin(0.25 * t) + 0.4 * std::sin(0.9 * t); };
  const auto speed_at = [&](double t) { return 25.0 + drive.speed_swing * std::sin(0.31 * t); };
  const auto side_at = [](double t) { return 0.5 * std::sin(0.8 * t); };
  std::vector<std::array<double, 2>> way{{0, 0}};
  const double step = dt / fine, begin = -2.0;
  for (int i = 0; i < (count + 200) * fine; ++i) {
    const double t = begin + (i + 0.5) * step, c = std::cos(yaw_at(t)), s = std::sin(yaw_at(t));
    way.push_back({way.back()[0] + step * (c * speed_at(t) - s * side_at(t)),
                   way.back()[1] + step * (s * speed_at(t) + c * side_at(t))});
  }
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  Channels out;
  for (int k = 0; k < count; ++k) {
    const double t = k * dt, place = t - drive.place_late, speed = t - drive.velocity_late;
    const auto& p = way[static_cast<std::size_t>(std::lround((place - begin) / step))];
    out.x.push_back(p[0] + drive.lever * std::cos(yaw_at(place)) + drive.noise * normal(random));
    out.y.push_back(p[1] + drive.lever * std::sin(yaw_at(place)) + drive.noise * normal(random));
    out.yaw.push_back(yaw_at(t) + 0.1 * drive.noise * normal(random));
    const double vx = drive.scale * speed_at(speed), vy = drive.scale * side_at(speed);
    out.vx.push_back(std::cos(drive.turned) * vx - std::sin(drive.turned) * vy + drive.noise * normal(random));
    out.vy.push_back(std::sin(drive.turned) * vx + std::cos(drive.turned) * vy + drive.noise * normal(random));
  }
  return out;
}

double lag_of(const Channels& channels) {
  const DisplacementLag lag(channels.motion());
  return lag.best(std::vector<int>(lag.blocks(), 1));
}

TEST(DisplacementLag, FindsWhichIsLateAndByHowMuch) {
  for (const double seconds : {0.0, 0.06, 0.11, 0.3}) {
    EXPECT_NEAR(lag_of(channels_of({.velocity_late = seconds})), seconds, 0.004) << seconds;
    EXPECT_NEAR(lag_of(channels_of({.place_late = seconds})), -seconds, 0.004) << seconds;
    EXPECT_NEAR(lag_of(channels_of({.place_late = seconds, .noise = 0})), -seconds, 5e-4) << seconds;
  }
}

TEST(DisplacementLag, ErrorsOfScaleAxesAndPlaceAreNoLag) {
  EXPECT_NEAR(lag_of(channels_of({.place_late = 0.1, .scale = 1.05})), -0.1, 0.004);
  EXPECT_NEAR(lag_of(channels_of({.place_late = 0.1, .turned = 0.03})), -0.1, 0.004);
  EXPECT_NEAR(lag_of(channels_of({.place_late = 0.1, .lever = 1.5})), -0.1, 0.004);
  EXPECT_NEAR(lag_of(channels_of({.lever = 1.5})), 0.0, 0.004);
}

/// At one speed a place further back on the car and a late one show the same: the blocks differ by more than the lag.
TEST(DisplacementLag, AtOneSpeedALeverMayBeALag) {
  const Channels steady = channels_of({.lever = 1.5, .speed_swing = 0});
  const DisplacementLag lag(steady.motion());
  double low = 1, high = -1;
  std::mt19937 random(1);
  for (int draw = 0; draw < 100; ++draw) {
    std::vector<int> weight(lag.blocks(), 0);
    for (std::size_t b = 0; b < lag.blocks(); ++b) ++weight[random() % lag.blocks()];
    low = std::min(low, lag.best(weight));
    high = std::max(high, lag.best(weight));
  }
  EXPECT_LT(low, 0.0);
  EXPECT_GT(high, -0.02);
}

TEST(DisplacementLag, WhatWasNotReadIsLeftOut) {
  Channels channels = channels_of({.place_late = 0.1});
  const double none = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 400; k < 700; ++k) channels.x[k] = channels.vx[k + 600] = channels.yaw[k + 1200] = none;
  EXPECT_NEAR(lag_of(channels), -0.1, 0.005);
}

TEST(DisplacementLag, SaysHowWellTheyAgreeAndWhereItsLagsEnd) {
  const DisplacementLag lag(channels_of({.place_late = 0.1}).motion());
  double correlation = 0;
  EXPECT_FALSE(lag.is_at_end(lag.best(std::vector<int>(lag.blocks(), 1), &correlation)));
  EXPECT_GT(correlation, 0.99);
  EXPECT_TRUE(lag.is_at_end(-1.2));
  EXPECT_TRUE(lag.is_at_end(1.2));
}

}  // namespace test_displacement_lag
}  // namespace gripline::measured
