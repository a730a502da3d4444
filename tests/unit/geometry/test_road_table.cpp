#include "geometry/road_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "geometry/track_file.hpp"
#include "support/host_support.hpp"
#include "support/sample_roads.hpp"

namespace gripline {
namespace test_road_table {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(RoadTable, ReverseSwapsTheSidesAndTurnsTheSlopes) {
  RoadTable road = test::ellipse();
  road.grade.assign(road.size(), 0.01);
  road.bank.assign(road.size(), 0.02);
  const PlanePoint first = road.points[0], second = road.points[1];
  reverse(road);
  EXPECT_EQ(road.points[0].x, first.x);
  EXPECT_EQ(road.points.back().y, second.y);
  EXPECT_EQ(road.right[5], 8.0);
  EXPECT_EQ(road.left[5], 4.0);
  EXPECT_EQ(road.grade[3], -0.01);
  EXPECT_EQ(road.bank[3], -0.02);
  reverse(road);
  EXPECT_EQ(road.points[1].y, second.y);
}

TEST(RoadTable, ScaleKeepsTheShape) {
  RoadTable road = test::ellipse();
  const double before = to_track(road).length();
  scale(road, 1.0 / 43.0);
  const Track small = to_track(road);
  EXPECT_NEAR(small.length(), before / 43.0, 1e-9);
  EXPECT_NEAR(small.half_width_left(1.0), 8.0 / 43.0, 1e-12);
}

TEST(RoadTable, StepsOfWidthAreFound) {
  RoadTable road = test::ellipse();
  for (std::size_t i = 40; i < 80; ++i) road.left[i] = 3.0;
  const std::vector<WidthStep> steps = width_steps(road);
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_FALSE(steps[0].right);
  EXPECT_EQ(steps[0].from, 8.0);
  EXPECT_EQ(steps[0].to, 3.0);
}

TEST(RoadTable, ABridgeSurvivesBeingWritten) {
  RoadTable road = test::figure_of_eight(5.0, 0.0);
  road.name = "eight";
  road.bridges = true;
  const Track track = to_track(road);
  const testing_support::Folder scratch;
  EXPECT_THAT([&] { write_road(scratch / "eight.csv", track, road); },
              ThrowsMessage<GeometryError>(HasSubstr("FILE.json")));
  write_road(scratch / "eight.json", track, road);
  const Track again = load_track(scratch / "eight.json");
  EXPECT_EQ(again.name(), "eight");
  EXPECT_EQ(again.crossings().size(), 1u);
  EXPECT_NEAR(again.length(), track.length(), 1e-3);
}

TEST(RoadTable, AStartIsScaledTurnedAndWritten) {
  RoadTable road = test::ellipse();
  road.start = Pose{0.0, 61.0, std::numbers::pi};
  scale(road, 0.5);
  reverse(road);
  EXPECT_EQ(road.start->x, 0.0);
  EXPECT_EQ(road.start->y, 30.5);
  EXPECT_NEAR(road.start->yaw, 0.0, 1e-15);
  const testing_support::Folder scratch;
  write_road(scratch / "ellipse.json", to_track(road), road);
  const Pose start = load_track(scratch / "ellipse.json").start();
  EXPECT_EQ(start.y, 30.5);
  EXPECT_EQ(start.yaw, road.start->yaw);
}

/// Two straights of 300 m with 6 points each, two half circles of 15 m radius with 12.
RoadTable few_points_on_the_straights() {
  RoadTable road;
  const auto corner = [&](double x, double from) {
    for (int i = 0; i < 12; ++i) {
      const double a = from + std::numbers::pi * i / 12;
      road.points.push_back({x + 15 * std::cos(a), 15 + 15 * std::sin(a)});
    }
  };
  for (int i = 0; i < 6; ++i) road.points.push_back({50.0 * i, 0.0});
  corner(300.0, -0.5 * std::numbers::pi);
  for (int i = 0; i < 6; ++i) road.points.push_back({300 - 50.0 * i, 30.0});
  corner(0.0, 0.5 * std::numbers::pi);
  road.right = road.left = std::vector<double>(road.size(), 4.0);
  return road;
}

TEST(RoadTable, AWrittenRoadKeepsItsCornersWhereItsStraightsHaveFewPoints) {
  const RoadTable road = few_points_on_the_straights();
  const Track track = to_track(road);
  const testing_support::Folder scratch;
  write_road(scratch / "road.csv", track, road);
  const Track again = load_track(scratch / "road.csv");
  for (double s = 0.0; s < track.length(); s += 0.5) {
    const CurvePoint at = track.at(s);
    EXPECT_NEAR(again.locate(at.x, at.y).n, 0.0, 0.03) << s;
  }
}

}  // namespace test_road_table
}  // namespace gripline
