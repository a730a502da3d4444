#include "geometry/track_import.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "geometry/track_file.hpp"
#include "support/paths.hpp"
#include "support/reference_data.hpp"
#include "support/road_files.hpp"
#include "support/sample_curves.hpp"

namespace gripline {
namespace test_track_import {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using testing_support::RoadFiles;

constexpr double pi = std::numbers::pi, kDegree = pi / 180.0;

TEST(TrackImport, EdgesOfAnAnnulusGiveItsMiddleCircle) {
  EdgePoints inner, outer;
  for (int i = 0; i < 200; ++i) {
    const double a = 2.0 * std::numbers::pi * i / 200, b = 2.0 * std::numbers::pi * (i + 0.3) / 200 + 0.4;
    inner.points.push_back({10.0 * std::cos(a), 10.0 * std::sin(a)});
    inner.heights.push_back(0.5 * std::sin(a));
    if (i % 3 != 0) {
      outer.points.push_back({16.0 * std::cos(b), 16.0 * std::sin(b)});
      outer.heights.push_back(0.5 * std::sin(b) + 0.6);
    }
  }
  const Track track(shape_from_edges(inner, outer, 1.0));
  EXPECT_NEAR(track.length(), 26.0 * std::numbers::pi, 0.05);
  for (double s = 0.0; s < track.length(); s += 0.9) {
    const CurvePoint at = track.at(s);
    EXPECT_NEAR(std::hypot(at.x, at.y), 13.0, 0.01);
    EXPECT_NEAR(track.half_width_left(s), 3.0, 0.02);
    EXPECT_NEAR(track.half_width_right(s), 3.0, 0.02);
    EXPECT_NEAR(track.bank(s), std::atan(0.6 / 6.0), 2e-3);  // counter-clockwise: the outer, higher edge is right
    EXPECT_NEAR(track.grade(s), 0.5 / 13.0 * std::cos(std::atan2(at.y, at.x)), 4e-3);  // straight between edge points
  }
  EXPECT_NEAR(Track(shape_from_edges(outer, inner, 1.0)).length(), track.length(), 1e-3);  // the names do not matter
  std::reverse(outer.points.begin(), outer.points.end());
  EXPECT_THROW(shape_from_edges(inner, outer), GeometryError);
}

class ImportedTracks : public testing_support::WithReference {};

TEST_F(ImportedTracks, PublishedTablesOfCentreAndEdges) {
  const Track ethz(shape_from_table(read_csv(reference("track_ethz.csv"))));
  EXPECT_NEAR(ethz.length(), 17.844, 5e-3);
  EXPECT_NEAR(ethz.half_width_left(1.0), 0.185, 1e-4);
  const Track ours = load_track(testing_support::source_dir() / "worlds/tracks/ethz.json");
  for (double s = 0.0; s < ethz.length(); s += 0.05) {
    const CurvePoint at = ethz.at(s);
    EXPECT_NEAR(ours.locate(at.x, at.y).n, 0.0, 1.5e-3);
  }
}

TEST_F(ImportedTracks, Town07WithItsSlope) {
  TrackShape shape = shape_from_table(read_csv(reference("track_carla.csv")), {.left_handed = true});
  const CsvTable line = read_csv(reference("raceline_carla_tum.csv")),
                 slope = read_csv(reference("carla_slope_profile.csv"));
  const std::vector<double> x = line.column("x_m"), y = line.column("y_m");
  std::vector<PlanePoint> points;
  for (std::size_t i = 0; i < x.size(); ++i) points.push_back({x[i], -y[i]});
  drop_closing_point_and_check_closed(points);
  const std::vector<double> stations = slope.column("s_m"), heights = slope.column("z_m"),
                            pitch = slope.column("pitch_deg");
  shape.grade = grade_from_heights(shape.centre, ClosedCurve::from_points(points), stations, heights);
  const Track track(std::move(shape));

  EXPECT_NEAR(track.length(), 1232.0, 1.0);
  EXPECT_NEAR(track.half_width_left(100.0), 1.5, 0.01);
  EXPECT_NEAR(track.half_width_right(700.0), 1.5, 0.01);
  // Clockwise seen in Carla's left-handed axes, so to us a lap turns once to the left or right, whole.
  double turned = 0.0, steepest = 0.0;
  for (double s = 0.0; s < track.length(); s += 0.25) {
    turned += 0.25 * track.at(s).kappa;
    steepest = std::max(steepest, std::abs(track.grade(s)));
  }
  EXPECT_NEAR(std::abs(turned), 2.0 * std::numbers::pi, 0.05);
  EXPECT_GT(steepest, 5.0 * kDegree);
  EXPECT_LT(steepest, 8.0 * kDegree);
  // The logged pitch of the body (nose up positive) follows the slope.
  double squares = 0.0;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    const CurvePoint at = ClosedCurve::from_points(points).at(stations[i]);
    const double difference = track.grade(track.locate(at.x, at.y).s) - pitch[i] * kDegree;
    squares += difference * difference;
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(stations.size())), 0.8 * kDegree);

  // As a file in the common convention it is the same road.
  std::ostringstream text;
  write_track_csv(text, track, 1.0);
  EXPECT_THAT(text.str(), StartsWith("# x_m,y_m,w_tr_right_m,w_tr_left_m,grade_rad,bank_rad\n"));
}

TEST_F(ImportedTracks, MeasuredCircuits) {
  for (const char* name : {"putnam", "lvms"}) {
    const auto edge = [name](const char* which) {
      return EdgePoints::from_table(read_csv(testing_support::reference_root() / "measured" /
                                             ("track_" + std::string(name) + "_" + which + ".csv")));
    };
    const Track track(shape_from_edges(edge("inner"), edge("outer")));
    EXPECT_GT(track.length(), 2300.0) << name;
    EXPECT_LT(track.length(), 3000.0) << name;
    EXPECT_GT(track.narrowest(), 6.0) << name;
  }
}

TEST_F(ImportedTracks, DiagnosisTracksHaveExactLapFractions) {
  for (const char* name : {"rc43_public.csv", "full_public.csv"}) {
    const auto file = testing_support::reference_root() / "discrepancy" / "tracks" / name;
    const Track track = load_track(file);
    const CsvTable table = read_csv(file);
    const std::vector<double> x = table.column("x_m"), y = table.column("y_m");
    double length = 0.0;
    std::vector<double> chord;
    for (std::size_t i = 0; i < x.size(); ++i) {
      chord.push_back(length);
      const std::size_t j = (i + 1) % x.size();
      length += std::hypot(x[j] - x[i], y[j] - y[i]);
    }
    for (std::size_t i = 0; i < x.size(); i += 7) EXPECT_NEAR(track.lap_fraction(x[i], y[i]), chord[i] / length, 1e-12);
    for (double s = 0.0; s < track.length(); s += track.length() / 777.0) {
      const CurvePoint at = track.at(s);
      EXPECT_NEAR(track.lap_fraction(at.x, at.y), s / track.length(), 1e-4) << name;  // framework/doc/axes-and-signs.md
    }
  }
}

constexpr const char* three_lines = "x_center_m,y_center_m,x_inner_m,y_inner_m,x_outer_m,y_outer_m";

/// Rows of a ring with its centre line at 100 m and its edges at these radii.
std::vector<double> ring(int i, double inner, double outer) {
  const double c = std::cos(2 * pi * i / 100), s = std::sin(2 * pi * i / 100);
  return {100 * c, 100 * s, inner * c, inner * s, outer * c, outer * s};
}

TEST_F(RoadFiles, AnEdgeThatLeavesItsSideIsRefusedByItsLine) {
  const auto shape = [&](double odd) {
    return shape_from_table(
        read_csv(write("ring.csv", three_lines, 100, [=](int i) { return ring(i, i == 7 ? odd : 96.0, 105.0); })));
  };
  EXPECT_NEAR(shape(97.0).half_width_left.minimum(), 3.0, 1e-9);
  EXPECT_THAT(refusal([&] { shape(102.0); }),
              HasSubstr("ring.csv:9:1: the inner edge is 2 m right of the centre line"));
  EXPECT_THAT(refusal([&] { shape(100.0); }), HasSubstr("ring.csv:9:1: the inner edge is 0 m"));
  const auto both = [&] {
    return shape_from_table(read_csv(write("ring.csv", three_lines, 100, [](int i) { return ring(i, 96, 98); })));
  };
  EXPECT_THAT(refusal(both), HasSubstr("lie on the same side"));
}

/// Edges whose rows begin elsewhere than those of the centre line are as wide as they are far along the road.
TEST_F(RoadFiles, EdgesThatDoNotCorrespondAreRefusedByTheirLine) {
  const auto shape = [&](int shifted) {
    return shape_from_table(read_csv(write("ring.csv", three_lines, 100, [=](int i) {
      std::vector<double> row = ring(i, 96, 105);
      const std::vector<double> other = ring(i + shifted, 96, 105);
      std::copy(other.begin() + 2, other.begin() + 4, row.begin() + 2);
      return row;
    })));
  };
  EXPECT_EQ(refusal([&] { shape(0); }), "not refused");
  EXPECT_THAT(refusal([&] { shape(2); }),
              HasSubstr("ring.csv:2:1: the point of the inner edge lies 12.03 m along the road from that of the centre "
                        "line and 4.757 m beside it; expected points that correspond"));
}

TEST_F(RoadFiles, ATraceInAWorldIsSentToItsWidth) {
  const auto file = write("trace.csv", "x_m,y_m", 20, [](int i) {
    return std::vector{50 * std::cos(i * pi / 10), 50 * std::sin(i * pi / 10)};
  });
  EXPECT_THAT(refusal([&] { load_track(file); }),
              HasSubstr("trace.csv:1:1: has no widths (w_tr_right_m,w_tr_left_m); gripline track FILE.csv --width"));
}

TEST_F(RoadFiles, TheClosingRowDoesNotCountAsAPoint) {
  const auto rows = [&](int points) {
    return write("few.csv", "x_m,y_m,w_tr_right_m,w_tr_left_m", points + 1, [=](int i) {
      const double a = 2 * pi * i / points;
      return std::vector{50 * std::cos(a), 50 * std::sin(a) + (i == points ? 1e-3 : 0.0), 3.0, 3.0};
    });
  };
  EXPECT_EQ(refusal([&] { load_track(rows(8)); }), "not refused");
  EXPECT_THAT(refusal([&] { load_track(rows(7)); }), HasSubstr("few.csv: has 7 points, a track needs at least 8"));
}

TEST_F(RoadFiles, AColumnThatIsThereTwiceIsRefused) {
  const auto file = write("twice.csv", "x_m,x_m,y_m,w_tr_right_m,w_tr_left_m", 20, [](int i) {
    return std::vector{0.0, 50 * std::cos(i / 3.0), 50 * std::sin(i / 3.0), 3.0, 3.0};
  });
  EXPECT_THAT(refusal([&] { load_track(file); }), HasSubstr("twice.csv:1:1: column \"x_m\" is there twice"));
  EXPECT_THAT(refusal([&] { read({file}); }), HasSubstr("twice.csv:1:1: column \"x_m\" is there twice"));
}

TEST(TrackImport, ALineMustCloseWithinFiveSteps) {
  std::vector<PlanePoint> arc;
  const auto check = [&](double share) {  // of a circle, in 100 steps
    arc.clear();
    for (int i = 0; i <= 100; ++i)
      arc.push_back({std::cos(2 * pi * share * i / 100), std::sin(2 * pi * share * i / 100)});
    drop_closing_point_and_check_closed(arc);
  };
  check(1.0);
  EXPECT_EQ(arc.size(), 100u);  // the last point repeated the first
  check(0.96);
  EXPECT_EQ(arc.size(), 101u);
  EXPECT_THROW(check(0.94), GeometryError);
}

/// A road with few points on its straights may begin at the end of one; a single long step is no leave for a longer gap.
TEST(TrackImport, AGapIsNoLongerThanStraightsWithoutPoints) {
  const auto check = [](double missing) {  // of a circle of 200 points beside one of 20 of its steps
    std::vector<PlanePoint> points;
    for (int i = 0; i < 200 - missing; ++i)
      if (i < 50 || i > 68) points.push_back({std::cos(2 * pi * i / 200), std::sin(2 * pi * i / 200)});
    drop_closing_point_and_check_closed(points);
  };
  check(40);
  EXPECT_THROW(check(80), GeometryError);
}

/// Both edges of a figure of eight, `half` metres beside its centre line, the right one with points between those of
/// the left; heights make the crossing a bridge.
struct Eight {
  static constexpr double half = 5.0;
  EdgePoints left, right;
  static PlanePoint centre(double a) { return {150 * std::sin(a), 75 * std::sin(2 * a)}; }
  static PlanePoint beside(double a, double n) {
    const double dx = 150 * std::cos(a), dy = 150 * std::cos(2 * a), way = std::hypot(dx, dy);
    return {centre(a).x - n * dy / way, centre(a).y + n * dx / way};
  }
  explicit Eight(double first) {
    for (int i = 0; i < 240; ++i) add(left, first + 2 * pi * i / 240, half);
    for (int i = 0; i < 301; ++i) add(right, first + 2 * pi * (i + 0.4) / 301, -half);
  }
  static void add(EdgePoints& edge, double a, double n) {
    edge.points.push_back(beside(a, n));
    edge.heights.push_back(10 * std::cos(a));  // the two passes are at a = 0 and a = pi
  }
};

/// Where the passes cross, the nearest place of an edge may be on the other pass. The road must follow its own,
/// wherever the files begin.
TEST(TrackImport, EdgesOfAFigureOfEightAreFollowedThroughTheCrossing) {
  for (const double first : {0.0, 0.02, 0.5 * pi, pi, 4.0}) {
    const Eight eight(first);
    const Track track(shape_from_edges(eight.left, eight.right));
    ASSERT_EQ(track.crossings().size(), 1u) << first;
    EXPECT_NEAR(std::abs(track.crossings()[0].height), 20.0, 0.5);
    for (double a = 0.0; a < 2 * pi; a += 0.01) {
      const double dx = 150 * std::cos(a), dy = 150 * std::cos(2 * a);
      const PlanePoint p = Eight::centre(a);
      const CurveLocation place = track.locate(Pose{p.x, p.y, std::atan2(dy, dx)});
      EXPECT_NEAR(place.n, 0.0, 0.05) << first << ' ' << a;
      EXPECT_NEAR(track.half_width_left(place.s), Eight::half, 0.05) << first << ' ' << a;
      EXPECT_NEAR(track.half_width_right(place.s), Eight::half, 0.05) << first << ' ' << a;
      EXPECT_NEAR(track.bank(place.s), 0.0, 0.05);
      EXPECT_NEAR(std::tan(track.grade(place.s)), -10 * std::sin(a) / std::hypot(dx, dy), 8e-3) << first << ' ' << a;
    }
  }
}

TEST(TrackImport, EdgesThatMakeNoRoadAreRefused) {
  const auto circle = [](double r, double direction, double x = 0.0) {
    EdgePoints edge;
    for (int i = 0; i < 100; ++i)
      edge.points.push_back({x + r * std::cos(2 * pi * i / 100), direction * r * std::sin(2 * pi * i / 100)});
    return edge;
  };
  const auto why = [](const EdgePoints& a, const EdgePoints& b) -> std::string {
    try {
      shape_from_edges(a, b);
    } catch (const GeometryError& error) {
      return error.what();
    }
    return "not refused";
  };
  EXPECT_EQ(why(circle(50, 1), circle(58, 1)), "not refused");
  EXPECT_EQ(why(circle(50, -1), circle(58, -1)), "not refused");
  EXPECT_THAT(why(circle(50, 1), circle(58, -1)), HasSubstr("reverse the rows of the one that does not"));
  EXPECT_THAT(why(circle(50, 1), circle(50, 1)), HasSubstr("are the same line"));
  EXPECT_THAT(why(circle(50, 1), circle(50, 1, 6.0)), HasSubstr("cross each other"));
}

/// Heights by station: what a height of first order in a circle's angle asks, and equal feet of two places.
TEST(GradeFromHeights, IsTheSlopeOfTheSpline) {
  const double length = 400.0, k = 2 * pi / length;
  std::vector<double> s, z;
  for (int i = 0; i < 60; ++i) s.push_back(length * i / 60.0 + 2.0), z.push_back(3 * std::sin(k * s.back()));
  const StationTable grade = grade_from_heights(length, s, z);
  for (double at = 0.0; at < length; at += 1.7)
    EXPECT_NEAR(grade.at(at), std::atan(3 * k * std::cos(k * at)), 3e-5) << at;
  EXPECT_THROW(grade_from_heights(length, std::vector{0.0, 5.0}, std::vector{0.0, 1.0}), GeometryError);
}

TEST(GradeFromHeights, PlacesWithOneFootAreOne) {
  const ClosedCurve centre = ClosedCurve::from_segments({10.0, 0.0, pi / 2}, std::vector{Segment::arc(10.0, 2 * pi)});
  for (const int at : {20, 0, 40}) {  // a line that goes round with a step straight outwards, also at its seam
    const double angle = 2 * pi * at / 40;
    std::vector<PlanePoint> points = test::ellipse_points(12.0, 12.0, 40);
    points.insert(points.begin() + at, {13 * std::cos(angle), 13 * std::sin(angle) - (at == 40 ? 1e-9 : 0.0)});
    const ClosedCurve along = ClosedCurve::from_points(points);
    const std::vector<double> stations = along.spline()->knot_stations();
    std::vector<double> heights;
    for (const PlanePoint& p : points) heights.push_back(0.1 * p.y);
    const StationTable grade = grade_from_heights(centre, along, stations, heights);
    for (double s = 0.0; s < centre.length(); s += 0.5)
      EXPECT_NEAR(std::tan(grade.at(s)), 0.12 * std::cos(s / 10), 5e-3) << at << ' ' << s;
  }
}

}  // namespace test_track_import
}  // namespace gripline
