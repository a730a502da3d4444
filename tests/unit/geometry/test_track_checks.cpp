#include "geometry/track_checks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "geometry/track_file.hpp"
#include "support/paths.hpp"
#include "support/sample_curves.hpp"
#include "support/sample_roads.hpp"

namespace gripline {
namespace test_track_checks {

using ::testing::HasSubstr;

constexpr double kPi = std::numbers::pi;

Track ethz() { return load_track(testing_support::source_dir() / "worlds/tracks/ethz.json"); }

TEST(TrackChecks, StartIsChecked) {
  const Track track = ethz();
  const Pose start = track.start();
  EXPECT_EQ(check_start(track, start), "");
  EXPECT_THAT(check_start(track, {start.x, start.y, start.yaw + kPi}),
              HasSubstr("faces backwards: yaw 135 deg, but the track runs -45 deg"));
  EXPECT_THAT(check_start(track, {start.x - 0.2, start.y - 0.2, start.yaw}),
              HasSubstr("off the track: 0.2828 m right"));
  EXPECT_EQ(check_start(track, {start.x, start.y, start.yaw + 1.0}), "");
}

TEST(TrackChecks, CarMustFit) {
  const Track track = ethz();
  EXPECT_EQ(check_car_fits(track, 0.03), "");
  EXPECT_THAT(check_car_fits(track, 0.4), HasSubstr("0.4 m wide, the track only 0.37 m"));
}

std::string why_refused(const RoadTable& road) {
  try {
    to_track(road);
  } catch (const GeometryError& error) {
    return error.what();
  }
  return "nothing";
}

std::string why_refused(const std::vector<PlanePoint>& points, double half_width) {
  RoadTable road;
  road.points = points;
  road.right = road.left = std::vector<double>(points.size(), half_width);
  return why_refused(road);
}

/// In a half circle a road becomes 4 m narrower on both sides. The edge of its narrow part lies within the half width
/// of places before it, across the bend, and is still nearest to its own.
TEST(TrackChecks, ARoadMayBecomeNarrowerInASharpBend) {
  constexpr double radius = 12.0, line = 60.0, half_turn = kPi * radius;
  const std::vector<Segment> oval{Segment::line(line), Segment::arc(radius, kPi), Segment::line(line),
                                  Segment::arc(radius, kPi)};
  const auto made = [&](double inner) {
    const double begins = line + 0.4 * half_turn, ends = line + 0.6 * half_turn;
    const StationTable half(2 * (line + half_turn), {0.0, begins, ends, line + half_turn + 20, 2 * line + half_turn},
                            {inner, inner, inner - 4.0, inner - 4.0, inner});
    return Track(
        TrackShape{.centre = ClosedCurve::from_segments({}, oval), .half_width_right = half, .half_width_left = half});
  };
  EXPECT_NO_THROW(made(11.5));
  EXPECT_THROW(made(14.5), GeometryError);  // an inner edge that folds
}

/// Two straights of 200 m and half circles of 40 m.
Track gated(double left, double right, double gate_left, double gate_right) {
  constexpr double radius = 40.0, line = 200.0;
  const std::vector<Segment> oval{Segment::line(line), Segment::arc(radius, kPi), Segment::line(line),
                                  Segment::arc(radius, kPi)};
  ClosedCurve centre = ClosedCurve::from_segments({}, oval);
  const auto table = [&](double usual, double gate) {
    return StationTable(centre.length(), {0.0, 80.0, 81.0, 90.0, 91.0}, {usual, usual, gate, gate, usual});
  };
  const StationTable on_left = table(left, gate_left), on_right = table(right, gate_right);
  return Track(TrackShape{.centre = std::move(centre), .half_width_right = on_right, .half_width_left = on_left});
}

TEST(TrackChecks, ARoadMayBecomeNarrowerWithinAMetre) {
  EXPECT_NO_THROW(gated(6.0, 6.0, 1.5, 1.5));
  EXPECT_NO_THROW(gated(6.0, 6.0, 0.5, 0.5));
  EXPECT_NO_THROW(gated(6.0, 6.0, 1.0, 11.0));
  EXPECT_NO_THROW(gated(3.0, 5.0, 3.0, 0.3));
}

/// Two straights 20 m apart, whose inner half widths overlap; the outer ones are small.
TEST(TrackChecks, AnOverlapIsSeenWhereTheRoadIsWiderOnOneSide) {
  const auto made = [](double left, double right, double turn) {
    const std::vector<Segment> oval{Segment::line(1000), Segment::arc(10, turn), Segment::line(1000),
                                    Segment::arc(10, turn)};
    return Track(
        TrackShape{.centre = ClosedCurve::from_segments({}, oval), .half_width_right = right, .half_width_left = left});
  };
  EXPECT_NO_THROW(made(9.0, 3.0, kPi));
  EXPECT_NO_THROW(made(3.0, 16.0, kPi));  // to the outside
  for (const double wide : {11.2, 13.0, 16.0, 17.0}) {
    EXPECT_THROW(made(wide, 3.0, kPi), GeometryError) << wide;
    EXPECT_THROW(made(3.0, wide, -kPi), GeometryError) << wide;
  }
}

TEST(TrackChecks, ALongNarrowRoadThatCrossesItselfIsRefused) {
  for (const double first : {0.1, 0.30123, 0.5, 0.7, 1.0}) {
    RoadTable road = test::figure_of_eight(10.0, 0.0, first);
    road.height.clear();
    scale(road, 25.0);  // 20 km
    road.right.assign(road.size(), 0.5);
    road.left = road.right;
    EXPECT_THAT(why_refused(road), HasSubstr("the road crosses or overlaps itself")) << first;
  }
}

/// Edges of a road laid over itself keep their distance from every centre line; the centre lines meet.
TEST(TrackChecks, ARoadOverItselfIsRefused) {
  std::vector<PlanePoint> twice, there_and_back, oval;
  for (int i = 0; i < 120; ++i) twice.push_back({5 * std::cos(2 * kPi * i / 60), 5 * std::sin(2 * kPi * i / 60)});
  EXPECT_THAT(why_refused(twice, 0.2), HasSubstr("the road runs over itself: it is at (5, "));
  // An oval that turns round on its straight, goes back over several points and on again.
  for (int i = 0; i < 80; ++i) oval.push_back({10 * std::cos(2 * kPi * i / 80), 5 * std::sin(2 * kPi * i / 80)});
  EXPECT_EQ(why_refused(oval, 0.2), "nothing");
  for (int i = 0; i < 80; ++i) {
    there_and_back.push_back(oval[static_cast<std::size_t>(i)]);
    if (i != 30) continue;
    for (const int back : {29, 28, 27, 26, 25, 26, 27, 28, 29, 30})
      there_and_back.push_back({oval[static_cast<std::size_t>(back)].x, oval[static_cast<std::size_t>(back)].y});
  }
  EXPECT_NE(why_refused(there_and_back, 0.2), "nothing");
  // A hairpin as tight as its width allows is no such thing.
  const std::vector<Segment> hairpin{Segment::line(6), Segment::arc(0.32, kPi), Segment::line(6),
                                     Segment::arc(0.32, kPi)};
  EXPECT_NO_THROW(Track(
      TrackShape{.centre = ClosedCurve::from_segments({}, hairpin), .half_width_right = 0.3, .half_width_left = 0.3}));
}

TEST(TrackChecks, MillimetresAreNoticed) {
  std::vector<PlanePoint> points;
  for (int i = 0; i < 60; ++i) points.push_back({2865 * std::cos(2 * kPi * i / 60), 2865 * std::sin(2 * kPi * i / 60)});
  EXPECT_EQ(why_refused(points, 185), "a lap of 18001 m with widths of 370 m: millimetres? Lengths are metres");
}

/// Places and widths in different units; roads as long and as short for their width as there are pass.
TEST(TrackChecks, UnitsOfPlacesAndWidthsThatDifferAreNoticed) {
  const auto why = [](double radius, double half_width) {
    std::vector<PlanePoint> points;
    for (int i = 0; i < 60; ++i)
      points.push_back({radius * std::cos(2 * kPi * i / 60), radius * std::sin(2 * kPi * i / 60)});
    return why_refused(points, half_width);
  };
  EXPECT_EQ(why(65.9e3, 4), "a lap of 414062 m with widths of 8 m: millimetres? Lengths are metres");
  EXPECT_THAT(why(0.0659, 4), HasSubstr("a lap of 0.4141 m with widths of 8 m: kilometres, degrees, or widths in"));
  EXPECT_THAT(why(30.0, 40), HasSubstr("; a lap of 188.5 m with widths of 80 m: are the widths metres?"));
  EXPECT_EQ(why(25e3 / 6.28, 4), "nothing");
  EXPECT_EQ(why(148e3 / 6.28, 2.5), "nothing");
  EXPECT_EQ(why(20.0 / 6.28, 0.185), "nothing");
  EXPECT_EQ(why(9.0, 1.5), "nothing");
}

TEST(TrackChecks, ACrossingIsABridgeWhereHeightsDifferOrTheRoadSaysSo) {
  RoadTable road = test::figure_of_eight(5.0, 0.0);
  EXPECT_THAT(why_refused(road), HasSubstr("\"bridges\": true says so"));
  road.bridges = true;
  const Track told = to_track(road);
  ASSERT_EQ(told.crossings().size(), 1u);
  EXPECT_NEAR(told.crossings()[0].x, 0.0, 0.1);
  EXPECT_NEAR(told.crossings()[0].angle, kPi / 2, 0.02);
  const Track high = to_track(test::figure_of_eight(5.0, 4.0));
  ASSERT_EQ(high.crossings().size(), 1u);
  EXPECT_NEAR(std::abs(high.crossings()[0].height), 8.0, 0.2);
  EXPECT_THAT(why_refused(test::figure_of_eight(5.0, 0.5)), HasSubstr("crosses or overlaps itself"));
}

TEST(TrackChecks, TwoWaysBesideEachOtherAreNoBridge) {
  // A flat figure of eight: it crosses itself at 11 degrees.
  RoadTable road = test::figure_of_eight(5.0, 0.0);
  for (PlanePoint& p : road.points) p.y *= 0.1;
  road.bridges = true;
  EXPECT_THAT(why_refused(road), HasSubstr("overlaps itself"));
  EXPECT_THAT(why_refused(road), HasSubstr("a crossing at 11.4 degrees"));
}

}  // namespace test_track_checks
}  // namespace gripline
