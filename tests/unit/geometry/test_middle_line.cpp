#include "geometry/middle_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace gripline {
namespace test_middle_line {

constexpr double pi = std::numbers::pi;

/// Points on a circle about (0, 0) from this angle on, counter-clockwise for a positive count, else clockwise.
std::vector<PlanePoint> circle(double radius, int count, double from = 0.0) {
  std::vector<PlanePoint> points;
  for (int i = 0; i < std::abs(count); ++i) {
    const double a = from + 2 * pi * i / count;
    points.push_back({radius * std::cos(a), radius * std::sin(a)});
  }
  return points;
}

TEST(MiddleLine, EdgesAreComparedBySideDistanceAndDirection) {
  const ClosedPolyline inner(circle(10, 200)), outer(circle(16, 150, 0.4)), back(circle(16, -150));
  const EdgeSides sides = compare_edges(inner, outer);
  EXPECT_NEAR(sides.distance, 6.0, 0.02);
  EXPECT_NEAR(sides.left, -6.0, 0.02);  // the outer edge is on the right of the inner one
  EXPECT_NEAR(sides.along, 1.0, 0.01);
  const PlanePoint here = inner.points()[sides.anchor], across = outer.at(sides.beside);
  EXPECT_NEAR(distance(here, across), 6.0, 0.02);
  EXPECT_NEAR(compare_edges(outer, inner).left, 6.0, 0.02);
  EXPECT_NEAR(compare_edges(inner, back).along, -1.0, 0.01);
}

TEST(MiddleLine, IsEquallyFarFromBothEdgesWhoseNumbersOfPointsDiffer) {
  const ClosedPolyline inner(circle(10, 200)), outer(circle(16, 150, 0.4));
  const MiddleLine middle = middle_line(inner, outer, compare_edges(inner, outer), 1.0);
  ASSERT_GT(middle.points.size(), 70u);
  ASSERT_LT(middle.points.size(), 90u);  // a circle of 13 m, every metre
  ASSERT_EQ(middle.on_inner.size(), middle.points.size());
  ASSERT_EQ(middle.on_outer.size(), middle.points.size());
  for (std::size_t i = 0; i < middle.points.size(); ++i) {
    const PlanePoint& p = middle.points[i];
    EXPECT_NEAR(std::hypot(p.x, p.y), 13.0, 0.01) << i;
    EXPECT_NEAR(distance(p, inner.at(middle.on_inner[i])), 3.0, 0.02) << i;
    EXPECT_NEAR(distance(p, outer.at(middle.on_outer[i])), 3.0, 0.02) << i;
  }
}

/// Forty points of a middle line and of both edges, which correspond. In one place the outer edge comes within the
/// inner one.
class CrossingEdges : public testing::Test {
 protected:
  static constexpr int count = 40;

  static std::string why_refused(std::size_t dented, bool inner_left) {
    std::vector<PlanePoint> outside = circle(16, count);
    if (dented < outside.size()) outside[dented] = circle(8, count)[dented];
    const ClosedPolyline inner(circle(10, count)), outer(outside);
    MiddleLine middle{circle(13, count), {}, {}};
    for (std::size_t i = 0; i < count; ++i) {
      middle.on_inner.push_back(inner.station(i));
      middle.on_outer.push_back(outer.station(i));
    }
    try {
      check_crossing(ClosedCurve::from_points(middle.points), middle, inner, outer, inner_left);
    } catch (const GeometryError& e) {
      return e.what();
    }
    return "nothing";
  }
};

TEST_F(CrossingEdges, AreRefusedWithThePlace) {
  EXPECT_EQ(why_refused(count, true), "nothing");
  EXPECT_EQ(why_refused(0, true),
            "the two edges cross each other: near (13, 0) the left one is to the right of the other");
  EXPECT_THAT(why_refused(10, true), testing::HasSubstr("near (0, 13)"));
  EXPECT_THAT(why_refused(count, false), testing::HasSubstr("cross each other"));  // the sides are stated wrongly
}

}  // namespace test_middle_line
}  // namespace gripline
