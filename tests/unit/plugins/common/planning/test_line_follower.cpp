#include "common/planning/line_follower.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
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
  EXPECT_NEAR(follower.locate(line, 0, -20), 100, 1);
  for (double y = -20; y < 10; y += 0.5) EXPECT_NEAR(follower.locate(line, 0, y), 100, 1) << "y = " << y;
  // The other straight is nearer by far, but the car is not on it.
  EXPECT_NEAR(follower.locate(line, 0, 14), 100, 1);
}

TEST(LineFollower, ACarOnAnotherStretchIsThere) {
  const ClosedLine line = oval();
  LineFollower follower;
  EXPECT_NEAR(follower.locate(line, 0, -20), 100, 1);
  const double other = 0.5 * line.length() + 100;
  EXPECT_NEAR(follower.locate(line, 0, 17), other, 1);
  EXPECT_NEAR(follower.locate(line, -10, 20), other + 10, 1);
}

TEST(LineFollower, BeginsAnywhere) {
  const ClosedLine line = oval();
  LineFollower follower;
  EXPECT_NEAR(follower.locate(line, 0, 60), 0.5 * line.length() + 100, 1);
  follower.forget();
  EXPECT_NEAR(follower.locate(line, 0, -60), 100, 1);
}

}  // namespace test_line_follower
}  // namespace gripline
