#include "common/planning/line_follower.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace gripline {
namespace test_line_follower {

using planning::ClosedLine;
using planning::LineFollower;

/// Two straights of 200 m, 40 m apart, and two half circles; the road is 10 m wide.
ClosedLine oval() {
  constexpr double straight = 200, radius = 20, half_width = 5, spacing = 1;
  const double turn = std::numbers::pi * radius, length = 2 * (straight + turn);
  const auto count = static_cast<std::size_t>(length / spacing);
  std::vector<LinePoint> samples(count);
  for (std::size_t i = 0; i < count; ++i) {
    LinePoint& p = samples[i];
    p.s = length * static_cast<double>(i) / static_cast<double>(count);
    const double half = std::fmod(p.s, straight + turn);
    const double sign = p.s < straight + turn ? 1.0 : -1.0;
    const double angle = std::max(0.0, half - straight) / radius;
    p.x = sign * (std::min(half, straight) - 0.5 * straight + radius * std::sin(angle));
    p.y = sign * -radius * std::cos(angle);
    p.yaw = angle + (sign > 0 ? 0.0 : std::numbers::pi);
    p.kappa = half > straight ? 1.0 / radius : 0.0;
    p.left = p.right = half_width;
  }
  return ClosedLine(samples);
}

TEST(LineFollower, ACarThatLeftTheRoadStaysBesideTheStretchWhereItDid) {
  const ClosedLine line = oval();
  LineFollower follower;
  EXPECT_NEAR(follower.locate(line, 0, -20, 0), 100, 1);
  for (double y = -20; y < 10; y += 0.5) EXPECT_NEAR(follower.locate(line, 0, y, 0), 100, 1) << "y = " << y;
  // The other straight is nearer by far, but the car is not on it.
  EXPECT_NEAR(follower.locate(line, 0, 14, 0), 100, 1);
}

TEST(LineFollower, ACarOnAnotherStretchIsThere) {
  const ClosedLine line = oval();
  LineFollower follower;
  EXPECT_NEAR(follower.locate(line, 0, -20, 0), 100, 1);
  const double other = 0.5 * line.length() + 100;
  EXPECT_NEAR(follower.locate(line, 0, 17, std::numbers::pi), other, 1);
  EXPECT_NEAR(follower.locate(line, -10, 20, std::numbers::pi), other + 10, 1);
}

TEST(LineFollower, BeginsAnywhere) {
  const ClosedLine line = oval();
  LineFollower follower;
  EXPECT_NEAR(follower.locate(line, 0, 60, std::numbers::pi), 0.5 * line.length() + 100, 1);
  follower.forget();
  EXPECT_NEAR(follower.locate(line, 0, -60, 0), 100, 1);
}

/// A line that runs over itself at a right angle; the road is 10 m wide.
ClosedLine eight() {
  constexpr int count = 600;
  const auto at = [](double a) { return std::pair(75 * std::sin(a), 37.5 * std::sin(2 * a)); };
  std::vector<LinePoint> samples;
  double a = 0;
  for (int i = 0; i < count; ++i) {
    const auto [x, y] = at(a);
    const double dx = 75 * std::cos(a), dy = 75 * std::cos(2 * a);
    LinePoint p;
    p.s = i;
    p.x = x;
    p.y = y;
    p.yaw = std::atan2(dy, dx);
    p.left = p.right = 5;
    samples.push_back(p);
    a += 2 * std::numbers::pi / count;
  }
  return ClosedLine(samples);
}

/// Up to the edge of the other pass and beyond, where that is the nearer one.
TEST(LineFollower, OnABridgeACarBeginsOnThePassThatItFollows) {
  const ClosedLine line = eight();
  for (const std::size_t middle : {0UL, 300UL})
    for (std::size_t i = 590; i <= 610; ++i)
      for (const double n : {-4.0, -2.0, 0.0, 2.0, 4.0})
        for (const double turned : {-0.5, 0.0, 0.5}) {
          const LinePoint& p = line.samples()[(middle + i) % 600];
          LineFollower follower;
          const double s = follower.locate(line, p.x - n * std::sin(p.yaw), p.y + n * std::cos(p.yaw), p.yaw + turned);
          EXPECT_NEAR(std::remainder(s - p.s, 600.0), 0.0, 1.0) << "n = " << n << ", sample " << i;
        }
}

}  // namespace test_line_follower
}  // namespace gripline
