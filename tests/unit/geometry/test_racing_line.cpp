#include "geometry/racing_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "geometry/course_adapter.hpp"
#include "geometry/cyclic_box_qp.hpp"
#include "geometry/road_table.hpp"
#include "geometry/track_file.hpp"
#include "geometry/track_import.hpp"
#include "support/comma_locale.hpp"
#include "support/paths.hpp"
#include "support/reference_data.hpp"
#include "support/sample_roads.hpp"

namespace gripline {
namespace test_racing_line {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr double kPi = std::numbers::pi;
constexpr double kCarWidth = 0.03;

Track shipped(const std::string& name) { return load_track(testing_support::source_dir() / "worlds/tracks" / name); }

Track ring(double radius, double half_width) {
  const std::vector<Segment> segments{Segment::arc(radius, 2.0 * kPi)};
  return Track(TrackShape{.centre = ClosedCurve::from_segments({}, segments),
                          .half_width_right = half_width,
                          .half_width_left = half_width});
}

struct Box {
  CyclicPentadiagonal hessian;
  std::vector<double> gradient, lower, upper;
};

Box random_box(std::mt19937_64& random, std::size_t n) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> wide(0.05, 1.0);
  Box box{CyclicPentadiagonal(n), std::vector<double>(n), std::vector<double>(n), std::vector<double>(n)};
  for (std::size_t row = 0; row < n; ++row) {  // a sum of squares of neighbouring triples
    const double a = normal(random), b = normal(random), c = normal(random);
    const std::size_t j = (row + 1) % n, k = (row + 2) % n;
    box.hessian.diagonal[row] += a * a + 1e-3;
    box.hessian.diagonal[j] += b * b;
    box.hessian.diagonal[k] += c * c;
    box.hessian.next[row] += a * b;
    box.hessian.next[j] += b * c;
    box.hessian.second[row] += a * c;
    box.gradient[row] = normal(random);
    box.lower[row] = -wide(random);
    box.upper[row] = wide(random);
  }
  return box;
}

TEST(CyclicPentadiagonal, FactorSolves) {
  std::mt19937_64 random(1);
  for (const std::size_t n : {8UL, 9UL, 50UL, 801UL}) {
    const Box box = random_box(random, n);
    std::vector<double> x(box.gradient);
    CyclicPentadiagonalFactor(box.hessian).solve(x);
    const std::vector<double> back = box.hessian.multiply(x);
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(back[i], box.gradient[i], 1e-9);
  }
}

TEST(CyclicBoxQp, SatisfiesTheOptimalityConditions) {
  std::mt19937_64 random(2);
  for (int k = 0; k < 20; ++k) {
    const Box box = random_box(random, 60);
    const std::vector<double> x = solve_cyclic_box_qp(box.hessian, box.gradient, box.lower, box.upper);
    const std::vector<double> hx = box.hessian.multiply(x);
    int at_bounds = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double slope = hx[i] + box.gradient[i];
      EXPECT_GT(x[i], box.lower[i]);
      EXPECT_LT(x[i], box.upper[i]);
      // No slope inside, a slope towards the bound at a bound.
      const double bound = slope > 0.0 ? box.lower[i] : box.upper[i];
      EXPECT_TRUE(std::abs(slope) <= 1e-5 || std::abs(x[i] - bound) <= 1e-5) << slope << " at " << x[i] - bound;
      at_bounds += std::abs(slope) > 1e-5 ? 1 : 0;
    }
    EXPECT_GT(at_bounds, 5);
  }
}

TEST(RacingLine, OnARingItRunsAlongTheOuterEdge) {
  // The integral of kappa^2 along a circle of radius r is 2 pi / r: the largest radius is best.
  const Track track = ring(1.0, 0.2);
  const RacingLine line = minimum_curvature_line(track, {.car_width = kCarWidth, .margin = 0.01});
  const double radius = 1.0 + 0.2 - 0.015 - 0.01;
  EXPECT_NEAR(line.length(), 2.0 * kPi * radius, 1e-4);
  EXPECT_NEAR(line.squared_curvature, 2.0 * kPi / radius, 1e-3);
  for (const RacingLineSample& at : line.samples) {
    EXPECT_NEAR(at.right, 0.025, 1e-4);
    EXPECT_NEAR(at.kappa, 1.0 / radius, 1e-3);
  }
}

TEST(RacingLine, AMarginToOneEdgeIsKeptFromThatOneAlone) {
  const RacingLine inside =
      minimum_curvature_line(ring(1.0, 0.2), {.car_width = kCarWidth, .margin = 0.01, .margin_right = 0.02});
  for (const RacingLineSample& at : inside.samples) EXPECT_NEAR(at.right, 0.045, 1e-4);
  const RacingLine widest = minimum_curvature_line(ring(1.0, 0.2), {.car_width = kCarWidth, .margin_left = 0.3});
  for (const RacingLineSample& at : widest.samples) EXPECT_NEAR(at.right, 0.015, 1e-4);
}

TEST(RacingLine, AHighPriceOnLengthMakesItTheShortest) {
  const RacingLine line = minimum_curvature_line(ring(1.0, 0.2), {.car_width = 0.1, .length_weight = 1e3});
  EXPECT_NEAR(line.length(), 2.0 * kPi * 0.85, 1e-3);
}

struct Case {
  const char* file;
  double length_weight;
  double longest, sharpest;  // what the line must not exceed [m], [1/m]
};

class OnEthz : public ::testing::TestWithParam<Case> {};

TEST_P(OnEthz, StaysInsideAndSaves) {
  const Track track = shipped(GetParam().file);
  const RacingLine line =
      minimum_curvature_line(track, {.car_width = kCarWidth, .length_weight = GetParam().length_weight});
  const RacingLine centre = describe_line(track, track.centre(), 0.01);
  for (const RacingLineSample& at : line.samples) {
    EXPECT_GE(at.left, 0.5 * kCarWidth - 5e-4);
    EXPECT_GE(at.right, 0.5 * kCarWidth - 5e-4);
    EXPECT_NEAR(at.left + at.right, 2.0 * track.half_width_left(at.centre_s), 1e-12);
  }
  EXPECT_LT(line.squared_curvature, 0.7 * centre.squared_curvature);
  EXPECT_LT(line.length(), GetParam().longest);
  EXPECT_LT(line.largest_curvature, GetParam().sharpest);
  RecordProperty("length_m", std::to_string(line.length()));
  RecordProperty("largest_curvature", std::to_string(line.largest_curvature));
}

/// The curvature integral of the line with a smooth bump of height `bump` across it around station s, clipped to the
/// bounds; measured as for the line itself.
double with_bump(const Track& track, const RacingLine& line, double s, double width, double bump) {
  std::vector<PlanePoint> points;
  for (const RacingLineSample& at : line.samples) {
    const double away = wrap_difference(at.s - s, line.length()) / width;
    const double wanted = bump * std::exp(-0.5 * away * away);
    const double room_left = at.left - 0.5 * kCarWidth, room_right = at.right - 0.5 * kCarWidth;
    const double n = std::clamp(wanted, std::min(-room_right, 0.0), std::max(room_left, 0.0));
    points.push_back({at.x - n * std::sin(at.yaw), at.y + n * std::cos(at.yaw)});
  }
  return describe_line(track, ClosedCurve::from_points(points), 0.005).squared_curvature;
}

/// The most that a bump of 4 mm to either side anywhere lowers the curvature integral.
double best_saving(const Track& track, const RacingLine& line) {
  const double own = with_bump(track, line, 0.0, 1.0, 0.0);
  double best = -INFINITY;
  for (double s = 0.0; s < line.length(); s += 0.21) {
    for (const double bump : {0.004, -0.004}) best = std::max(best, own - with_bump(track, line, s, 0.35, bump));
  }
  return best;
}

TEST(RacingLine, NoBumpInsideTheBoundsLowersItsCurvature) {
  for (const char* name : {"ethz.json", "ethz_mobil.json"}) {
    const Track track = shipped(name);
    constexpr double kResolution = 2e-3;  // of the comparison, 1/m: 0.005 % of the integral
    EXPECT_LT(best_saving(track, minimum_curvature_line(track, {.car_width = kCarWidth, .spacing = 0.01})), kResolution)
        << name;
    // A line that is a little too short is found out.
    EXPECT_GT(best_saving(track, minimum_curvature_line(
                                     track, {.car_width = kCarWidth, .spacing = 0.01, .length_weight = 1.0})),
              kResolution)
        << name;
  }
}

TEST(RacingLine, DoesNotDependOnTheGrid) {
  const Track track = shipped("ethz.json");
  const RacingLine coarse = minimum_curvature_line(track, {.car_width = kCarWidth, .spacing = 0.04});
  const RacingLine fine = minimum_curvature_line(track, {.car_width = kCarWidth, .spacing = 0.015});
  EXPECT_NEAR(coarse.squared_curvature, fine.squared_curvature, 0.005 * fine.squared_curvature);
  EXPECT_NEAR(coarse.length(), fine.length(), 0.01 * fine.length());
}

INSTANTIATE_TEST_SUITE_P(Lines, OnEthz,
                         ::testing::Values(Case{"ethz.json", 0.0, 16.7, 4.1}, Case{"ethz.json", 0.2, 16.3, 4.1},
                                           Case{"ethz_mobil.json", 0.0, 11.1, 4.0},
                                           Case{"ethz_mobil.json", 0.2, 11.0, 4.1}));

TEST(RacingLine, RespectsACurvatureBound) {
  // A short line with tight corners, which the bound opens again.
  const Track track = shipped("ethz.json");
  const RacingLine free = minimum_curvature_line(track, {.car_width = kCarWidth, .length_weight = 8.0});
  const RacingLine bounded =
      minimum_curvature_line(track, {.car_width = kCarWidth, .max_curvature = 5.0, .length_weight = 8.0});
  EXPECT_GT(free.largest_curvature, 6.0);
  EXPECT_LT(bounded.largest_curvature, 5.3);
  // The car's smallest turning radius is 0.17 m; eq. (1)'s own line asks for less than that without a bound.
  EXPECT_LT(minimum_curvature_line(track, {.car_width = kCarWidth}).largest_curvature, 1.0 / 0.17);
}

TEST(RacingLine, ARoadTooNarrowForTheCarIsRefused) {
  EXPECT_THROW(minimum_curvature_line(ring(1.0, 0.2), {.car_width = 0.4}), GeometryError);
  EXPECT_THROW(minimum_curvature_line(ring(1.0, 0.2), {.car_width = 0.2, .margin = 0.1}), GeometryError);
}

TEST(RacingLine, WhatThePlannersMarginTakesIsSaid) {
  EXPECT_THAT([] { minimum_curvature_line(ring(1.0, 0.2), {.car_width = 0.2, .margin = 0.15}); },
              ThrowsMessage<GeometryError>(HasSubstr("the planner's \"margin\" is 0.15 m of that on both sides")));
}

TEST(RacingLine, TheSamplesLieOnItsCurve) {
  const Track track = shipped("ethz_mobil.json");
  const RacingLine line = minimum_curvature_line(track, {.car_width = kCarWidth});
  ASSERT_FALSE(line.samples.empty());
  const double step = line.length() / static_cast<double>(line.samples.size());
  for (std::size_t i = 0; i < line.samples.size(); ++i) {
    const RacingLineSample& at = line.samples[i];
    EXPECT_NEAR(at.s, step * static_cast<double>(i), 1e-9);
    EXPECT_NEAR(line.curve.locate(at.x, at.y).n, 0.0, 1e-9);
    const CurvePoint centre = track.at(at.centre_s);
    EXPECT_NEAR(at.x, centre.x - at.n * std::sin(centre.yaw), 1e-9);
    EXPECT_NEAR(at.y, centre.y + at.n * std::cos(centre.yaw), 1e-9);
    // Between samples the curvature is as smooth as a line to steer along must be.
    EXPECT_LT(std::abs(line.samples[(i + 1) % line.samples.size()].kappa - at.kappa), 0.35);
  }
}

/// Two straights joined by half circles of this radius [m].
Track hairpins(double radius, double half_width) {
  RoadTable road;
  const int per_arc = 60, per_line = 40;
  for (const double side : {1.0, -1.0}) {
    for (int i = 0; i < per_line; ++i) road.points.push_back({side * (-60 + 120.0 * i / per_line), -side * radius});
    for (int i = 0; i < per_arc; ++i) {
      const double a = -0.5 * kPi + kPi * i / per_arc;
      road.points.push_back({side * (60 + radius * std::cos(a)), side * radius * std::sin(a)});
    }
  }
  road.right.assign(road.size(), half_width);
  road.left = road.right;
  return to_track(road);
}

TEST(RacingLine, AHairpinThatTheCarCannotSteerIsNamedWithItsRadius) {
  const Track track = hairpins(6.0, 3.0);
  EXPECT_EQ(check_car_turns(track, 1.8, 5.0), "");
  // The outer edge lets the widest line be wider than the centre line.
  EXPECT_EQ(check_car_turns(track, 1.8, 6.5), "");
  EXPECT_THAT(check_car_turns(track, 1.8, 12.0), HasSubstr("a turn is tighter than the car can steer: at s = "));
  EXPECT_THAT(check_car_turns(track, 1.8, 12.0), HasSubstr("the car's least is 12 m"));
}

/// On the wrong pass of its bridge a line would lie far from its stations, across the road.
TEST(RacingLine, ALineThatBeginsOnABridgeFollowsItsOwnPass) {
  for (const double first : {0.0, 0.2, -0.2, 120.0, 119.7}) {
    RoadTable road = test::figure_of_eight(5.0, 0.0, first);
    road.bridges = true;
    const Track track = to_track(road);
    const RacingLine line = minimum_curvature_line(track, {.car_width = 1.8});
    ASSERT_FALSE(line.samples.empty());
    for (const RacingLineSample& at : line.samples) {
      ASSERT_LT(std::abs(at.n), 5.0) << "first point at " << first << ", s = " << at.s;
      ASSERT_LT(std::abs(wrap_angle(at.yaw - track.at(at.centre_s).yaw)), 0.3) << first << ", s = " << at.s;
    }
    std::vector<LinePoint> seen(400);
    TrackCourse(track, Car{.width = 1.8}).minimum_curvature({}, seen);
    for (const LinePoint& at : seen)
      ASSERT_LT(std::abs(wrap_angle(at.yaw - track.at(at.station).yaw)), 0.3) << first << ", s = " << at.s;
  }
}

using RacingLineInCommaLocale = testing_support::InCommaLocale;

TEST_F(RacingLineInCommaLocale, MessagesHavePoints) {
  try {
    minimum_curvature_line(ring(1.0, 0.2), {.car_width = 0.5});
    FAIL() << "a road of 0.4 m is wide enough for a car of 0.5 m";
  } catch (const GeometryError& error) {
    EXPECT_STREQ(error.what(), "no racing line: at s = 0 m the road is 0.4 m wide, the car with its margins 0.5 m");
  }
}

class LargeRoads : public testing_support::WithReference {};

TEST_F(LargeRoads, Town07IsWithinTheBoundsToo) {
  const Track track(shape_from_table(read_csv(reference("track_carla.csv")), {.left_handed = true}));
  const RacingLine line = minimum_curvature_line(track, {.car_width = 1.8, .spacing = 1.0});
  EXPECT_NEAR(line.length(), 1218.0, 8.0);  // the published line, with a quarter of a metre more room, has 1218 m
  for (const RacingLineSample& at : line.samples) {
    EXPECT_GE(at.left, 0.9 - 0.03);
    EXPECT_GE(at.right, 0.9 - 0.03);
  }
}

}  // namespace test_racing_line
}  // namespace gripline
