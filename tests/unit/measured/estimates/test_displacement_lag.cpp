#include "measured/estimates/displacement_lag.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
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

struct Shown {
  std::vector<double> x, y, yaw, vx, vy;
  PlaneMotion motion() const { return {x, y, yaw, vx, vy, dt}; }
};

Shown show(const Drive& drive, std::uint64_t seed = 7) {
  constexpr int fine = 20, count = 3000;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const double a = normal(random), b = normal(random), c = normal(random);
  const auto yaw_at = [&](double t) { return 1.5 * std::sin(0.25 * t + a) + 0.4 * std::sin(0.9 * t + b); };
  const auto speed_at = [&](double t) { return 25.0 + drive.speed_swing * std::sin(0.31 * t + c); };
  const auto side_at = [](double t) { return 0.5 * std::sin(0.8 * t); };
  std::vector<std::array<double, 2>> way{{0, 0}};
  const double step = dt / fine, begin = -2.0;
  for (int i = 0; i < (count + 200) * fine; ++i) {
    const double t = begin + (i + 0.5) * step, cosine = std::cos(yaw_at(t)), sine = std::sin(yaw_at(t));
    way.push_back({way.back()[0] + step * (cosine * speed_at(t) - sine * side_at(t)),
                   way.back()[1] + step * (sine * speed_at(t) + cosine * side_at(t))});
  }
  Shown out;
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

double lag_of(const Drive& drive) {
  const auto lag = displacement_lag(show(drive).motion());
  return lag ? lag->seconds : std::numeric_limits<double>::quiet_NaN();
}

TEST(DisplacementLag, FindsWhichIsLateAndByHowMuch) {
  for (const double seconds : {0.0, 0.06, 0.113, 0.3}) {
    EXPECT_NEAR(lag_of({.velocity_late = seconds}), seconds, 0.004) << seconds;
    EXPECT_NEAR(lag_of({.place_late = seconds}), -seconds, 0.004) << seconds;
    EXPECT_NEAR(lag_of({.place_late = seconds, .noise = 0}), -seconds, 5e-4) << seconds;
  }
}

TEST(DisplacementLag, ErrorsOfScaleAxesAndPlaceAreNoLag) {
  EXPECT_NEAR(lag_of({.place_late = 0.1, .scale = 1.05}), -0.1, 0.004);
  EXPECT_NEAR(lag_of({.place_late = 0.1, .turned = 0.03}), -0.1, 0.004);
  EXPECT_NEAR(lag_of({.place_late = 0.1, .lever = 1.5}), -0.1, 0.004);
  EXPECT_NEAR(lag_of({.lever = 1.5}), 0.0, 0.004);
}

/// The true lag lies within so many standard deviations as often as it should by Student's t of a few blocks, whether
/// the speed changes or a lever could take the lag's place.
TEST(DisplacementLag, IsAsSureAsItSays) {
  for (const auto& [swing, noise, least] :
       {std::tuple(12.0, 0.05, 24), {12.0, 0.1, 10}, {3.0, 0.1, 0}, {0.0, 0.1, 0}}) {
    int beyond_two = 0, beyond_four = 0, known = 0;
    double worst = 0;
    constexpr int drives = 24;
    for (int seed = 0; seed < drives; ++seed) {
      const auto lag =
          displacement_lag(show({.noise = noise, .speed_swing = swing}, static_cast<std::uint64_t>(seed)).motion());
      if (!lag) continue;
      ++known;
      worst = std::max(worst, std::abs(lag->seconds));
      const double off = std::abs(lag->seconds) / lag->sigma;
      beyond_two += off > 2.57 ? 1 : 0;   // 5 % by Student's t of five degrees of freedom
      beyond_four += off > 6.87 ? 1 : 0;  // 0.1 %
    }
    EXPECT_LE(beyond_two, 4) << swing;
    EXPECT_LE(beyond_four, 1) << swing;
    EXPECT_LT(worst, 0.02) << swing;
    EXPECT_GE(known, least) << swing;
    EXPECT_TRUE(swing > 0 || known == 0) << "noise says which lag is best";
  }
}

/// At one speed a place further back on the car and a late one show the same: neither is known.
TEST(DisplacementLag, AtOneSpeedALeverMayBeALag) {
  const auto swinging = displacement_lag(show({.lever = 1.5}).motion());
  const auto steady = displacement_lag(show({.lever = 1.5, .speed_swing = 0}).motion());
  ASSERT_TRUE(swinging);
  EXPECT_LT(swinging->sigma, 0.003);
  EXPECT_FALSE(steady);
}

TEST(DisplacementLag, WhatWasNotReadIsLeftOut) {
  Shown shown = show({.place_late = 0.1});
  const double none = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 400; k < 700; ++k) shown.x[k] = shown.vx[k + 600] = shown.yaw[k + 1200] = none;
  const auto lag = displacement_lag(shown.motion());
  ASSERT_TRUE(lag);
  EXPECT_NEAR(lag->seconds, -0.1, 0.005);
  EXPECT_GT(lag->explained, 0.99);
  std::ranges::fill(shown.vy, none);
  EXPECT_FALSE(displacement_lag(shown.motion()));
}

/// Five blocks, as many as there are unknowns, hardly differ once these are fitted to them.
TEST(DisplacementLag, IsNotToldByAFewBlocks) {
  Shown shown = show({.place_late = 0.1});
  ASSERT_TRUE(displacement_lag(shown.motion()));
  for (std::size_t k = 1800; k < shown.vx.size(); ++k) shown.vx[k] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(displacement_lag(shown.motion()));
}

TEST(DisplacementLag, IsNoneBeyondWhatIsTried) {
  EXPECT_FALSE(displacement_lag(show({.velocity_late = 1.5}).motion()));
}

}  // namespace test_displacement_lag
}  // namespace gripline::measured
