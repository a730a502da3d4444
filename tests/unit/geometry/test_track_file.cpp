#include "geometry/track_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "config/json_file.hpp"
#include "geometry/track_checks.hpp"
#include "support/paths.hpp"
#include "util/numbers.hpp"

namespace gripline {
namespace test_track_file {

using ::testing::HasSubstr;

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
  EXPECT_THAT(file_refusal("open.csv"), testing::AllOf(HasSubstr("the line is open: its last point is"),
                                                       testing::EndsWith("; gripline track --close METRES closes it")));
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

/// Two rings of 20 points, 10 m and 11 m from their centre.
TEST(TrackFile, EdgesMayNotBecomeMorePointsThanMemoryHolds) {
  const std::filesystem::path folder = testing::TempDir();
  for (const double radius : {10.0, 11.0}) {
    std::ofstream out(folder / format("gripline_ring%.0f.csv", radius));
    out << "x_m,y_m\n";
    for (int i = 0; i < 20; ++i)
      out << radius * std::cos(i * 0.1 * std::numbers::pi) << ',' << radius * std::sin(i * 0.1 * std::numbers::pi)
          << '\n';
  }
  const auto edges = [&](const char* spacing) {
    return R"({"edges": {"inner": ")" + (folder / "gripline_ring10.csv").string() + R"(", "outer": ")" +
           (folder / "gripline_ring11.csv").string() + R"(", "spacing": )" + spacing + "}}";
  };
  EXPECT_NEAR(parse(edges("0.5")).narrowest(), 1.0, 0.05);
  EXPECT_THAT(refusal(edges("1e-5")),
              HasSubstr("/edges/spacing: 1e-05 m are 6.26e+06 points on an edge of 62.574 m, expected at most 100000"));
}

TEST(TrackFile, FormatsOfOtherToolsAreSentToGriplineTrack) {
  const std::filesystem::path folder = testing::TempDir();
  for (const auto& [name, text] : {std::pair{"gripline_heights.csv", "x_m,y_m,w_tr_right_m,w_tr_left_m,z_m\n"},
                                   {"gripline_earth.csv", "lat,lon,a,b,c\n"},
                                   {"gripline_survey.csv", "easting,northing,right,left,id\n"},
                                   {"gripline_road.gpx", "<gpx/>\n"}}) {
    std::ofstream(folder / name) << text << (std::string_view(name).ends_with(".csv") ? "1,2,3,4,5\n" : "");
    EXPECT_THAT(refusal('"' + (folder / name).string() + '"'), HasSubstr("--out ROAD.json makes a road of it")) << name;
  }
  EXPECT_THAT(refusal('"' + (folder / "gripline_earth.csv").string() + '"'),
              HasSubstr("track FILE.csv --width METRES"));
  std::ofstream(folder / "gripline_road.xodr") << "<OpenDRIVE/>\n";
  EXPECT_THAT(refusal('"' + (folder / "gripline_road.xodr").string() + '"'),
              testing::AllOf(HasSubstr("is OpenDRIVE, which is not read; export its reference line as a CSV"),
                             testing::Not(HasSubstr("gripline track"))));
  EXPECT_THAT(refusal('"' + (folder / "gripline_no_road.gpx").string() + '"'),
              testing::Not(HasSubstr("gripline track")));
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
  EXPECT_THAT(refusal(stadium(R"("half_width": 0.3, "start": {"x": 1, "y": 30, "yaw": "0 deg"})")),
              HasSubstr("/start: start (1, 30) is off the track"));
  EXPECT_THAT(refusal(stadium(R"("half_width": 0.3, "start": {"x": 1, "y": 0, "yaw": "180 deg"})")),
              HasSubstr("/start: start faces backwards"));
  EXPECT_THAT(refusal(R"({"half_width": 0.3})"), HasSubstr("exactly one of \"segments\", \"centre\" and \"edges\""));
  EXPECT_THAT(refusal(R"({"centre": "oval.cvs"})"), HasSubstr("oval.csv"));
  const std::string points = testing::TempDir() + "gripline_oval.txt";
  std::filesystem::copy_file(fixture("oval.csv"), points, std::filesystem::copy_options::overwrite_existing);
  EXPECT_THAT(refusal(R"({"centre": ")" + points + "\"}"), HasSubstr("expected a file whose name ends in .csv"));
  EXPECT_THAT(refusal('"' + points + '"'), HasSubstr("expected a file whose name ends in .json or .csv"));
  EXPECT_THAT(refusal(stadium(R"("half_width": 0.3, "grade": [{"s": 0, "grade": "2 deg"}])")),
              HasSubstr("the grade does not close: after one lap the road is 0.4988 m higher"));
  EXPECT_THAT(
      refusal(stadium(R"("half_width": 0.3, "height": [{"s": 0, "z": 0}, {"s": 4, "z": 0}, {"s": 4.1, "z": 3}])")),
      HasSubstr(" rad at s = "));
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

}  // namespace test_track_file
}  // namespace gripline
