#include "common/planning/dubins.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <random>

namespace gripline {
namespace test_dubins {

using planning::DubinsPath;
using planning::PathPoint;
using planning::PlanePose;

constexpr double radius = 8.0;

PlanePose drawn(std::mt19937& random) {
  const auto within = [&](double size) { return std::uniform_real_distribution<double>(-size, size)(random); };
  return {within(40), within(40), within(std::numbers::pi)};
}

TEST(Dubins, EveryKindLeadsFromPoseToPoseOnItsRadius) {
  std::mt19937 random(7);
  int found[DubinsPath::kinds] = {};
  for (int trial = 0; trial < 200; ++trial) {
    const PlanePose from = drawn(random), to = drawn(random);
    for (int kind = 0; kind < DubinsPath::kinds; ++kind) {
      const std::optional<DubinsPath> path = DubinsPath::between(from, to, radius, kind);
      if (!path) continue;
      ++found[kind];
      const PathPoint first = path->at(0.0), last = path->at(path->length());
      EXPECT_NEAR(std::hypot(first.x - from.x, first.y - from.y), 0.0, 1e-9);
      EXPECT_NEAR(std::hypot(last.x - to.x, last.y - to.y), 0.0, 1e-6) << "kind " << kind;
      EXPECT_NEAR(std::remainder(last.yaw - to.yaw, 2.0 * std::numbers::pi), 0.0, 1e-6) << "kind " << kind;
      EXPECT_GE(path->length(), std::hypot(to.x - from.x, to.y - from.y) - 1e-9);
    }
  }
  for (int kind = 0; kind < DubinsPath::kinds; ++kind) EXPECT_GT(found[kind], kind < 2 ? 199 : 50) << "kind " << kind;
}

/// A step along it moves by that step, and turns by the curvature that is stated.
TEST(Dubins, IsMeasuredByItsLength) {
  const std::optional<DubinsPath> path = DubinsPath::between({0, 0, 0}, {-5, 3, std::numbers::pi}, radius, 4);
  ASSERT_TRUE(path);
  const double step = 0.01;
  for (double way = 0.0; way + step < path->length(); way += step) {
    const PathPoint p = path->at(way), q = path->at(way + step);
    EXPECT_NEAR(std::hypot(q.x - p.x, q.y - p.y), step, 1e-6);
    EXPECT_LE(std::abs(q.yaw - p.yaw), step / radius + 1e-9);
    EXPECT_NEAR(std::abs(p.curvature), 1.0 / radius, 1e-12);
  }
}

TEST(Dubins, StraightAheadIsStraight) {
  const std::optional<DubinsPath> path = DubinsPath::between({0, 0, 0}, {30, 0, 0}, radius, 0);
  ASSERT_TRUE(path);
  EXPECT_NEAR(path->length(), 30.0, 1e-9);
}

}  // namespace test_dubins
}  // namespace gripline
