#include "geometry/track_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "config/json_file.hpp"
#include "geometry/track_import.hpp"
#include "support/paths.hpp"
#include "support/reference_data.hpp"

namespace gripline {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr double kDegree = std::numbers::pi / 180.0;

std::string fixture(const std::string& name) { return testing_support::fixture_dir() / "tracks" / name; }

Track parse(const std::string& text) {
  Errors errors;
  std::optional<Track> track =
      read_track(parse_text(text, "world.json", testing_support::fixture_dir() / "tracks"), errors);
  errors.throw_if_any();
  return std::move(track.value());
}

std::string refusal(const std::string& text) {
  try {
    parse(text);
  } catch (const InputError& error) {
    EXPECT_EQ(error.diagnostics().size(), 1U) << error.what();
    return error.what();
  }
  return "not refused";
}

std::string file_refusal(const std::string& name) {
  try {
    load_track(fixture(name));
  } catch (const InputError& error) {
    EXPECT_EQ(error.diagnostics().size(), 1U) << error.what();
    EXPECT_THAT(error.what(), HasSubstr(name));
    return error.what();
  }
  return "not refused";
}

/// A stadium of two 4 m straights and two half circles of radius 1 m with some more keys.
std::string stadium(const std::string& more) {
  return R"({"segments": [{"line": 4}, {"arc": {"radius": 1, "turn": "180 deg"}}, {"line": "400 cm"},
             {"arc": {"radius": 1, "turn": "180 deg"}}])" +
         (more.empty() ? std::string() : ", " + more) + "}";
}

TEST(TrackFile, CsvFormsThatWork) {
  const Track oval = load_track(fixture("oval.csv"));
  EXPECT_EQ(oval.name(), "oval");
  EXPECT_EQ(oval.half_width_left(1.0), 0.2);
  for (const char* same : {"last_equals_first.csv", "crlf.csv"}) {
    const Track track = load_track(fixture(same));
    EXPECT_EQ(track.length(), oval.length()) << same;
    EXPECT_EQ(track.at(3.3).kappa, oval.at(3.3).kappa) << same;
  }
}

TEST(TrackFile, CsvFormsThatAreRefused) {
  EXPECT_THAT(file_refusal("open.csv"), HasSubstr("the line is open: its last point is"));
  EXPECT_THAT(file_refusal("repeated_point.csv"), HasSubstr("repeated_point.csv:12:1: repeats the point of line 11"));
  EXPECT_THAT(file_refusal("too_few_points.csv"), HasSubstr("has 4 points, a track needs at least 8"));
  EXPECT_THAT(file_refusal("nan.csv"), HasSubstr("nan.csv:9:1: expected a finite number, found \"nan\""));
  EXPECT_THAT(file_refusal("semicolons.csv"), HasSubstr("separated by ';'"));
  EXPECT_THAT(file_refusal("semicolon_rows.csv"), HasSubstr("semicolon_rows.csv:2:"));
  EXPECT_THAT(file_refusal("decimal_commas.csv"), HasSubstr("is the decimal sign a comma?"));
  EXPECT_THAT(file_refusal("unknown_column.csv"), HasSubstr("\"w_right_m\"; did you mean \"w_tr_right_m\"?"));
  EXPECT_THAT(file_refusal("no_header.csv"), HasSubstr("the first line must name the columns"));
  EXPECT_THAT(file_refusal("crosses_itself.csv"), HasSubstr("crosses or overlaps itself"));
  EXPECT_THAT(file_refusal("overlaps_itself.csv"), HasSubstr("crosses or overlaps itself"));
  EXPECT_THAT(file_refusal("too_sharp.csv"), HasSubstr("bends more sharply (radius 0.2"));
  EXPECT_THAT(file_refusal("no_width.csv"), HasSubstr("left half width is 0 m"));
  EXPECT_THAT(file_refusal("rows_of_different_length.csv"), HasSubstr(":7:"));
  EXPECT_THAT(file_refusal("empty.csv"), HasSubstr("empty"));
  EXPECT_THAT(file_refusal("grade_does_not_close.csv"), HasSubstr("higher than where it began"));
  EXPECT_THAT(file_refusal("oval.cvs"), HasSubstr("no such file; did you mean \"oval.csv\"?"));
}

TEST(TrackFile, JsonOfSegments) {
  const Track track =
      parse(stadium(R"("name": "stadium", "origin": {"x": 1, "y": 2, "yaw": "90 deg"}, "half_width": "30 cm",
                                       "start": {"x": 1, "y": 3, "yaw": "90 deg"})"));
  EXPECT_EQ(track.name(), "stadium");
  EXPECT_NEAR(track.length(), 8.0 + 2.0 * std::numbers::pi, 1e-12);
  EXPECT_NEAR(track.at(4.0).y, 6.0, 1e-12);
  EXPECT_EQ(track.half_width_right(0.0), 0.3);
  EXPECT_EQ(track.start().y, 3.0);
  EXPECT_NEAR(track.at(1.0).yaw, 90.0 * kDegree, 1e-12);
}

TEST(TrackFile, JsonWidths) {
  const Track sides = parse(stadium(R"("half_width": {"left": 0.3, "right": 0.4})"));
  EXPECT_EQ(sides.half_width_left(7.0), 0.3);
  EXPECT_EQ(sides.half_width_right(7.0), 0.4);
  const Track table =
      parse(stadium(R"("half_width": [{"s": 0, "left": 0.3, "right": 0.4}, {"s": 2, "left": 0.5, "right": 0.4}])"));
  EXPECT_NEAR(table.half_width_left(1.0), 0.4, 1e-12);
  EXPECT_EQ(table.half_width_right(1.0), 0.4);
}

TEST(TrackFile, JsonSlopesAndWalls) {
  const Track track = parse(stadium(R"("half_width": 0.3,
      "grade": [{"s": 0, "grade": 0}, {"s": 2, "grade": "4 deg"}, {"s": 4, "grade": 0}, {"s": 6, "grade": "-4 deg"}, {"s": 8, "grade": 0}],
      "bank": [{"s": 0, "bank": 0}, {"s": 5, "bank": "3 deg"}],
      "walls": [{"side": "left", "from_s": 1, "to_s": 3, "distance": 0.5}, {"side": "left", "from_s": 3, "to_s": 4, "distance": 1}])"));
  EXPECT_NEAR(track.grade(2.0), 4.0 * kDegree, 1e-12);
  EXPECT_NEAR(track.grade(5.0), -2.0 * kDegree, 1e-12);
  EXPECT_NEAR(track.bank(2.5), 1.5 * kDegree, 1e-12);
  const auto clearance = [&track](double s, double n) { return track.wall_clearance({s, n, 0.0, 0.0}); };
  EXPECT_TRUE(std::isinf(clearance(0.5, 0.1)));
  EXPECT_NEAR(clearance(1.0, 0.1), 0.7, 1e-12);
  EXPECT_NEAR(clearance(2.99, 0.9), -0.1, 1e-12);
  EXPECT_NEAR(clearance(3.5, 0.1), 1.2, 1e-12);
  EXPECT_TRUE(std::isinf(clearance(4.5, 0.1)));
  EXPECT_TRUE(std::isinf(clearance(2.0, -0.1)));
  const Track all_round = parse(stadium(R"("half_width": 0.3, "walls": {"left": 2, "right": 3})"));
  EXPECT_NEAR(all_round.wall_clearance({0.0, -0.3, 0.0, 0.0}), 3.0, 1e-12);
}

TEST(TrackFile, HeightsGiveAGradeThatCloses) {
  const Track track = parse(stadium(R"("half_width": 0.3,
      "height": [{"s": 0, "z": 0}, {"s": 3.5, "z": 0.1}, {"s": 7, "z": 0.3}, {"s": 11, "z": 0.2}])"));
  double z = 0.0;
  const double step = 1e-3;
  double at_seven = 0.0;
  for (double s = 0.5 * step; s < track.length(); s += step) {
    z += step * std::tan(track.grade(s));
    if (std::abs(s - 7.0) < step) at_seven = z;
  }
  EXPECT_NEAR(z, 0.0, 2e-3);
  EXPECT_NEAR(at_seven, 0.3, 2e-3);
}

TEST(TrackFile, JsonOfACsvFile) {
  const Track track = parse(
      R"({"centre": "hill.csv", "name": "hill", "walls": {"left": 1, "right": 1}, "start": {"x": 2, "y": 0, "yaw": "90 deg"}})");
  EXPECT_EQ(track.name(), "hill");
  EXPECT_EQ(check_start(track, track.start()), "");
  EXPECT_NEAR(track.bank(0.0), 0.02, 1e-12);
  EXPECT_EQ(parse("\"oval.csv\"").name(), "oval");
}

TEST(TrackFile, NamesTheTablesOfARoadInJson) {
  const auto names = [](const char* text) { return named_tables(parse_text(text, "road.json", "/roads")); };
  using Files = std::vector<std::filesystem::path>;
  EXPECT_EQ(names(R"({"centre": "a.csv"})"), Files{"/roads/a.csv"});
  EXPECT_EQ(names(R"({"edges": {"inner": "in.csv", "outer": "../out.csv"}})"), (Files{"/roads/in.csv", "/out.csv"}));
  EXPECT_EQ(names(R"({"segments": []})"), Files{});
}

TEST(TrackFile, AMirroredFileTurnsTheOtherWay) {
  const Track track = load_track(fixture("hill.csv")),
              mirrored = parse(R"({"centre": "hill.csv", "left_handed": true})");
  EXPECT_NEAR(mirrored.length(), track.length(), 1e-12);
  EXPECT_NEAR(mirrored.at(2.0).kappa, -track.at(2.0).kappa, 1e-12);
  EXPECT_NEAR(mirrored.at(2.0).y, -track.at(2.0).y, 1e-12);
  EXPECT_NEAR(mirrored.bank(2.0), -track.bank(2.0), 1e-12);
  EXPECT_NEAR(mirrored.grade(2.0), track.grade(2.0), 1e-12);
}

TEST(TrackFile, JsonRefusals) {
  EXPECT_THAT(refusal(stadium("")), HasSubstr("half_width"));
  EXPECT_THAT(refusal(stadium(R"("half_width": 0)")), HasSubstr("/half_width"));
  EXPECT_THAT(refusal(stadium(R"("half_width": 1.2)")),
              HasSubstr("bends more sharply (radius 1 m at s = 14.26 m) than its half width 1.2 m allows"));
  EXPECT_THAT(refusal(stadium(R"("half_width": 0.3, "half_with": 1)")), HasSubstr("half_with"));
  EXPECT_THAT(
      refusal(R"({"segments": [{"line": 4}, {"arc": {"radius": 1, "turn": "180 deg"}}], "half_width": 0.3})"),
      HasSubstr(
          "/segments: the segments do not close: the last ends with heading 180 deg, the first begins with 0 deg"));
  EXPECT_THAT(refusal(R"({"segments": [{"line": 4}, {"arc": {"radius": 1, "turn": "180 deg"}}, {"line": 3.99},
                          {"arc": {"radius": 1, "turn": "180 deg"}}], "half_width": 0.3})"),
              HasSubstr("do not close: the last ends 0.01 m from the start"));
  EXPECT_THAT(refusal(R"({"segments": [{"arc": {"radius": 1, "turn": "3 m"}}], "half_width": 0.3})"),
              HasSubstr("\"3 m\" is a length, expected an angle"));
  EXPECT_THAT(refusal(R"({"segments": [{"curve": 1}], "half_width": 0.3})"),
              HasSubstr("unknown key \"curve\"; known: line, arc"));
  EXPECT_THAT(refusal(R"({"half_width": 0.3})"), HasSubstr("exactly one of \"segments\", \"centre\" and \"edges\""));
  EXPECT_THAT(refusal(R"({"centre": "oval.cvs"})"), HasSubstr("oval.csv"));
  EXPECT_THAT(refusal(stadium(R"("half_width": 0.3, "grade": [{"s": 0, "grade": "2 deg"}])")),
              HasSubstr("the grade does not close: after one lap the road is 0.4988 m higher"));
  EXPECT_THAT(refusal(stadium(R"("half_width": 0.3, "bank": [{"s": 3, "bank": 0}, {"s": 2, "bank": 0}])")),
              HasSubstr("/bank: row 2 of a table by station has station 2"));
  EXPECT_THAT(
      refusal(stadium(R"("half_width": 0.3, "walls": [{"side": "up", "from_s": 1, "to_s": 3, "distance": 0.5}])")),
      HasSubstr("/walls/0/side"));
  EXPECT_THAT(refusal(R"({"centre": "hill.csv", "bank": [{"s": 0, "bank": 0.1}]})"),
              HasSubstr("/bank: the points' file already has this"));
  EXPECT_THAT(refusal("12"), HasSubstr("expected a track"));
}

TEST(TrackFile, WrittenCsvReadsBackAsTheSameRoad) {
  const Track track = load_track(testing_support::source_dir() / "worlds/tracks/ethz_mobil.json");
  const auto file = std::filesystem::path(::testing::TempDir()) / "gripline_written_track.csv";
  std::ofstream out(file);
  write_track_csv(out, track, 0.02);
  out.close();
  const Track again = load_track(file);
  std::filesystem::remove(file);
  EXPECT_NEAR(again.length(), track.length(), 1e-3);
  for (double s = 0.0; s < track.length(); s += 0.07) {
    const CurvePoint at = track.at(s);
    EXPECT_NEAR(again.locate(at.x, at.y).n, 0.0, 1e-4);
    EXPECT_EQ(again.half_width_left(s), 0.23);
  }
}

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

}  // namespace
}  // namespace gripline
