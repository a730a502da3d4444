#include "geometry/crossings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "support/sample_curves.hpp"

namespace gripline {
namespace test_crossings {

using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kPi = std::numbers::pi;

/// A figure of eight of 300 m, 8 m wide, whose passes cross at (0, 0) at this angle [rad]. One of them is `above` [m]
/// higher than the other.
TrackShape figure_of_eight(double angle, double above = 0.0) {
  constexpr int count = 240;
  std::vector<PlanePoint> points;
  for (int i = 0; i < count; ++i) {
    const double a = 2 * kPi * (i + 0.5) / count;
    points.push_back({150 * std::sin(a), 75 * std::tan(angle / 2) * std::sin(2 * a)});
  }
  TrackShape shape{.centre = ClosedCurve::from_points(points), .half_width_right = 4.0, .half_width_left = 4.0};
  if (above == 0.0) return shape;
  // Up in one half of the lap, down in the other.
  const double length = shape.centre.length(), grade = 2 * above / length;
  shape.grade = StationTable(length, {0.0, 0.5 * length - 0.01, 0.5 * length, length - 0.01},
                             {std::atan(grade), std::atan(grade), -std::atan(grade), -std::atan(grade)});
  return shape;
}

Crossings crossings_of(const TrackShape& shape) {
  const std::vector<RoadStation> road = road_stations(shape, 1.0);
  return Crossings(shape, road);
}

TEST(Crossings, ARoadThatCrossesNothingHasNone) {
  const TrackShape shape{.centre = test::stadium(), .half_width_right = 0.3, .half_width_left = 0.3};
  const Crossings none = crossings_of(shape);
  EXPECT_THAT(none.bridges(), IsEmpty());
  EXPECT_THAT(none.at_grade(), IsEmpty());
  EXPECT_THAT(none.shallow(), IsEmpty());
  EXPECT_EQ(none.no_bridge(), nullptr);
}

TEST(Crossings, OneAtGradeIsNoBridgeUnlessTheRoadSaysSo) {
  TrackShape shape = figure_of_eight(kPi / 2);
  const Crossings flat = crossings_of(shape);
  EXPECT_THAT(flat.bridges(), IsEmpty());
  ASSERT_THAT(flat.at_grade(), SizeIs(1));
  const Crossing& c = flat.at_grade().front();
  EXPECT_NEAR(c.x, 0.0, 0.1);
  EXPECT_NEAR(c.y, 0.0, 0.1);
  EXPECT_NEAR(c.angle, kPi / 2, 0.02);
  EXPECT_NEAR(c.second - c.first, 0.5 * shape.centre.length(), 0.1);
  EXPECT_EQ(flat.no_bridge(), &flat.at_grade().front());
  EXPECT_FALSE(flat.bridge_explains(c.first, c.second));

  shape.bridges = true;
  const Crossings told = crossings_of(shape);
  EXPECT_THAT(told.bridges(), SizeIs(1));
  EXPECT_EQ(told.no_bridge(), nullptr);
}

TEST(Crossings, AQuarterOfTheWidthInHeightMakesABridge) {
  EXPECT_EQ(crossings_of(figure_of_eight(kPi / 2)).clearance(), 2.0);
  EXPECT_THAT(crossings_of(figure_of_eight(kPi / 2, 1.5)).bridges(), IsEmpty());
  const Crossings high = crossings_of(figure_of_eight(kPi / 2, 2.5));
  ASSERT_THAT(high.bridges(), SizeIs(1));
  EXPECT_NEAR(std::abs(high.bridges().front().height), 2.5, 0.1);
}

TEST(Crossings, BelowThirtyDegreesNothingIsABridge) {
  TrackShape shape = figure_of_eight(kPi / 7);
  shape.bridges = true;
  const Crossings flat = crossings_of(shape);
  EXPECT_THAT(flat.bridges(), IsEmpty());
  ASSERT_THAT(flat.shallow(), SizeIs(1));
  EXPECT_NEAR(flat.shallow().front().angle, kPi / 7, 0.02);
  EXPECT_EQ(flat.no_bridge(), &flat.shallow().front());
}

/// A bridge explains that its two passes share a place near it, in either order; not farther off, nor one pass alone.
TEST(Crossings, ABridgeExplainsOverlapsNearIt) {
  TrackShape shape = figure_of_eight(kPi / 2);
  shape.bridges = true;
  const Crossings crossings = crossings_of(shape);
  ASSERT_THAT(crossings.bridges(), SizeIs(1));
  const Crossing& c = crossings.bridges().front();
  EXPECT_TRUE(crossings.bridge_explains(c.first, c.second));
  EXPECT_TRUE(crossings.bridge_explains(c.second + 5.0, c.first - 5.0));
  EXPECT_FALSE(crossings.bridge_explains(c.first, c.second + 20.0));
  EXPECT_FALSE(crossings.bridge_explains(c.first, c.first));
}

}  // namespace test_crossings
}  // namespace gripline
