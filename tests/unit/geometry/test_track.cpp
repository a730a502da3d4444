#include "geometry/track.hpp"

#include <gtest/gtest.h>

#include <random>

#include "geometry/lap_counter.hpp"
#include "geometry/track_checks.hpp"
#include "geometry/track_file.hpp"
#include "support/allocation_counter.hpp"
#include "support/paths.hpp"
#include "support/reference_data.hpp"
#include "support/sample_curves.hpp"
#include "support/sample_roads.hpp"
#include "util/csv.hpp"

namespace gripline {
namespace test_track {

using test::beside;
using test::stadium;

constexpr double kPi = std::numbers::pi;

Track shipped(const std::string& name) { return load_track(testing_support::source_dir() / "worlds/tracks" / name); }

TEST(ClosedCurve, QueriesAllocateNothing) {
  const Track arcs = shipped("ethz.json");
  const Track points = load_track(testing_support::fixture_dir() / "tracks/hill.csv");
  const long before = rig::allocations.load();
  double sum = 0.0;
  for (const Track* track : {&arcs, &points}) {
    for (double s = -1.0; s < 20.0; s += 0.37) {
      const CurvePoint at = track->at(s);
      const CurveLocation place = track->locate(at.x, at.y, s), anywhere = track->locate(at.x + 0.01, at.y);
      sum += place.n + anywhere.s + track->half_width_left(s) + track->half_width_right(s) + track->grade(s) +
             track->bank(s);
      sum += track->lap_fraction(at.x, at.y, place) + track->beyond_edge(place) + track->wall_clearance(place);
    }
  }
  EXPECT_EQ(rig::allocations.load(), before);
  EXPECT_TRUE(std::isinf(sum));  // no walls: the sum was not optimised away
}

TEST(Track, EthzClosesAndHasThePublishedSize) {
  const Track ethz = shipped("ethz.json"), mobil = shipped("ethz_mobil.json");
  EXPECT_NEAR(ethz.length(), 17.84405, 1e-5);
  EXPECT_NEAR(mobil.length(), 12.8549, 5e-5);
  for (const Track* track : {&ethz, &mobil}) {
    const CurvePoint end = track->at(track->length() - 1e-9), begin = track->at(0.0);
    EXPECT_NEAR(end.x, begin.x, 1e-8);
    EXPECT_NEAR(end.y, begin.y, 1e-8);
    EXPECT_NEAR(wrap_angle(end.yaw - begin.yaw), 0.0, 1e-7);
    EXPECT_EQ(check_start(*track, track->start()), "");
  }
  EXPECT_NEAR(ethz.start().x, -0.84574, 1e-12);
  EXPECT_NEAR(ethz.start().yaw, -kPi / 4, 1e-12);
  EXPECT_EQ(ethz.half_width_left(3.0), 0.185);
  EXPECT_EQ(mobil.half_width_right(3.0), 0.23);
}

class ReferenceTracks : public testing_support::WithReference {
 protected:
  /// Largest distance of the published centre and edge points from ours.
  static void expect_within(const Track& track, const CsvTable& table, double tolerance, double spiral_begin = 0.0,
                            double spiral_end = 0.0) {
    const std::vector<double> cx = table.column("x_center_m"), cy = table.column("y_center_m");
    const std::vector<double> ix = table.column("x_inner_m"), iy = table.column("y_inner_m");
    const std::vector<double> ox = table.column("x_outer_m"), oy = table.column("y_outer_m");
    double inner_side = 0.0;
    for (std::size_t i = 0; i < cx.size(); ++i) {
      const CurveLocation centre = track.locate(cx[i], cy[i]);
      EXPECT_NEAR(centre.n, 0.0, tolerance) << "centre point " << i;
      const CurveLocation inner = track.locate(ix[i], iy[i], centre.s), outer = track.locate(ox[i], oy[i], centre.s);
      const double edge_tolerance = centre.s > spiral_begin && centre.s < spiral_end ? 3e-3 : tolerance;
      EXPECT_NEAR(track.beyond_edge(inner), 0.0, edge_tolerance) << "inner point " << i;
      EXPECT_NEAR(track.beyond_edge(outer), 0.0, edge_tolerance) << "outer point " << i;
      EXPECT_LT(inner.n * outer.n, 0.0);
      inner_side += inner.n;
    }
    EXPECT_GT(std::abs(inner_side) / static_cast<double>(cx.size()), 0.1);
  }
};

TEST_F(ReferenceTracks, OurArcsAreWithinAMillimetre) {
  // In ETHZ's spiral the published edge points lie up to 10 degrees off the normals of the published centre line, which
  // makes that road up to 3 mm narrower than its half width of 0.185 m; its centre points are within the millimetre
  // too.
  expect_within(shipped("ethz.json"), read_csv(reference("track_ethz.csv")), 1e-3, 5.13, 6.63);
  expect_within(shipped("ethz_mobil.json"), read_csv(reference("track_ethzMobil.csv")), 1e-3);
}

TEST(Track, SidesTablesAndLapFraction) {
  const Track hill = load_track(testing_support::fixture_dir() / "tracks/hill.csv");
  EXPECT_NEAR(hill.grade(0.25 * hill.length()), 0.05, 1e-3);  // a quarter round the oval by symmetry
  EXPECT_NEAR(hill.grade(0.75 * hill.length()), -0.05, 1e-3);
  EXPECT_NEAR(hill.bank(1.0), 0.02, 1e-15);
  const Track oval = load_track(testing_support::fixture_dir() / "tracks/oval.csv");
  const CsvTable table = read_csv(testing_support::fixture_dir() / "tracks/oval.csv");
  const std::vector<double> x = table.column("x_m"), y = table.column("y_m");
  std::vector<double> chord{0.0};
  for (std::size_t i = 0; i < x.size(); ++i) {
    const std::size_t j = (i + 1) % x.size();
    chord.push_back(chord.back() + std::hypot(x[j] - x[i], y[j] - y[i]));
  }
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(oval.lap_fraction(x[i], y[i]), chord[i] / chord.back(), 1e-12);
  // Beside the road the search around the foot agrees with the search everywhere.
  const ClosedPolyline whole([&] {
    std::vector<PlanePoint> points;
    for (std::size_t i = 0; i < x.size(); ++i) points.push_back({x[i], y[i]});
    return points;
  }());
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> station(0.0, oval.length()), offset(-0.5, 0.4);
  for (int i = 0; i < 500; ++i) {
    const PlanePoint p = beside(oval.at(station(random)), offset(random));
    EXPECT_DOUBLE_EQ(oval.lap_fraction(p.x, p.y), whole.fraction(p.x, p.y));
  }
}

TEST(Track, EdgesAndWallsAreMeasuredOnTheRightSide) {
  TrackShape shape{.centre = stadium(), .half_width_right = 0.3, .half_width_left = 0.5};
  shape.wall_right = 0.2;
  const Track track(std::move(shape));
  EXPECT_NEAR(track.beyond_edge(track.locate(2.0, 0.4)), -0.1, 1e-12);
  EXPECT_NEAR(track.beyond_edge(track.locate(2.0, -0.4)), 0.1, 1e-12);
  EXPECT_TRUE(track.inside(track.locate(2.0, -0.2999)));
  EXPECT_NEAR(track.wall_clearance(track.locate(2.0, -0.45)), 0.05, 1e-12);
  EXPECT_LE(track.wall_clearance(track.locate(2.0, -0.5001)), 0.0);
  EXPECT_TRUE(std::isinf(track.wall_clearance(track.locate(2.0, 0.45))));
  EXPECT_NEAR(track.narrowest(), 0.8, 1e-12);
}

/// A place of 2 mm, where the left half is narrow and the right one is not at its widest.
TEST(Track, TheNarrowestPlaceIsFoundHoweverShort) {
  TrackShape shape{.centre = stadium(), .half_width_right = 0.3, .half_width_left = 0.5};
  const double length = shape.centre.length();
  shape.half_width_left = StationTable(length, {0.0, 1.234, 1.235, 1.236}, {0.5, 0.5, 0.2, 0.5});
  shape.half_width_right = StationTable(length, {1.0, 2.0}, {0.3, 0.4});
  EXPECT_DOUBLE_EQ(Track(std::move(shape)).narrowest(), 0.2 + 0.3 + 0.1 * 0.235);
}

TEST(Track, SlopeTurnsWithTheCar) {
  const Track hill = shipped("hill.json");
  const double s = 300.0;  // climbing, banked 5 degrees into a left turn
  const CurveLocation place{s, 0.0, hill.at(s).yaw};
  const double grade = hill.grade(s), bank = hill.bank(s);
  ASSERT_GT(grade, 0.01);
  ASSERT_GT(bank, 0.08);
  const auto seen = [&](double turned) { return hill.slope(place, place.yaw + turned); };
  EXPECT_NEAR(seen(0.0).grade, grade, 1e-12);
  EXPECT_NEAR(seen(0.0).bank, bank, 1e-12);
  EXPECT_NEAR(seen(kPi).grade, -grade, 1e-12);
  EXPECT_NEAR(seen(kPi).bank, -bank, 1e-12);
  // Facing left, towards the lower side: downhill ahead, and the right side of the car is the one ahead on the road.
  EXPECT_NEAR(seen(kPi / 2).grade, -bank, 1e-12);
  EXPECT_NEAR(seen(kPi / 2).bank, grade, 1e-12);
  // A banked turn presses the car on: the slope along it grows by kappa sin(bank) per metre.
  const double ahead = 0.5, yaw = place.yaw;
  const auto at = [&](double way) { return hill.slope({s + way, 0.0, hill.at(s + way).yaw}, yaw).grade; };
  const double road = (hill.grade(s + ahead) - hill.grade(s - ahead)) / (2 * ahead);
  EXPECT_NEAR((at(ahead) - at(-ahead)) / (2 * ahead), road + hill.at(s).kappa * std::sin(bank), 1e-4);
  EXPECT_GT(hill.at(s).kappa, 0.03);
}

TEST(Track, ABridgeAtTheFirstPointIsFoundOnce) {
  for (const double degrees : {35.0, 60.0, 75.0, 90.0, 105.0, 120.0}) {
    for (const int count : {200, 238, 240, 301}) {
      RoadTable road;
      for (int i = 0; i < count; ++i) {
        const double a = 2 * kPi * i / count;
        road.points.push_back({150 * std::sin(a), 75 * std::tan(degrees * kPi / 360.0) * std::sin(2 * a)});
      }
      road.right = road.left = std::vector<double>(road.size(), 4.0);
      road.bridges = true;
      const Track track = to_track(road);
      ASSERT_EQ(track.crossings().size(), 1u) << degrees << " " << count;
      EXPECT_NEAR(wrap_difference(track.crossings()[0].first, track.length()), 0.0, 0.1);
    }
  }
}

TEST(Track, OnABridgeTheCarsPlaceFollowsItsHeading) {
  const Track track = to_track(test::figure_of_eight(5.0, 4.0));
  const Crossing c = track.crossings().front();
  for (const double s : {c.first, c.second}) {
    const CurvePoint at = track.at(s);
    EXPECT_NEAR(wrap_difference(track.locate(Pose{at.x, at.y, at.yaw}).s - at.s, track.length()), 0.0, 1e-6);
    EXPECT_EQ(check_start(track, {at.x, at.y, at.yaw}), "");
    // Two metres beside its own pass, the car is nearer to the other one.
    const Pose beside{at.x - 2.0 * std::sin(at.yaw), at.y + 2.0 * std::cos(at.yaw), at.yaw};
    EXPECT_NEAR(wrap_difference(LapCounter(track, beside).place().s - at.s, track.length()), 0.0, 0.1);
  }
}

}  // namespace test_track
}  // namespace gripline
