// Roads as users bring them: gripline track.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/paths.hpp"
#include "support/program.hpp"

namespace gripline {
namespace test_cli_track {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using namespace testing_support;
namespace fs = std::filesystem;

class CliTrack : public testing::Test {
 protected:
  std::string out(const std::string& name = "out") const { return folder_ / name; }
  Folder folder_;
};

/// A line of radius 100 m, of whose 200 points one has another radius [m].
std::string circle_with_a_point_at(double radius) {
  std::string text = "x_m,y_m\n";
  for (int i = 0; i < 200; ++i) {
    const double r = i == 70 ? radius : 100.0;
    text +=
        std::to_string(r * std::cos(0.0314159265 * i)) + "," + std::to_string(r * std::sin(0.0314159265 * i)) + "\n";
  }
  return text;
}

TEST_F(CliTrack, TrackReadsRepairsAndWritesARoad) {
  const std::string road = fixture_dir() / "tracks/oval.csv";
  const Outcome made = gripline_with({"track", road, "--scale", "1:2", "--reverse", "--smooth", "0.01", "--out",
                                      out("small.csv"), "--picture", out("small.svg")});
  EXPECT_EQ(made.code, 0) << made.err;
  EXPECT_THAT(made.out, AllOf(HasSubstr("length "), HasSubstr("sharpest bend"), HasSubstr("small.svg")));
  EXPECT_THAT(contents(out("small.svg")), HasSubstr("<svg"));
  const Outcome again = gripline_with({"validate", out("small.csv")});
  EXPECT_EQ(again.code, 0) << again.err;
  // A car, or the car of a world.
  for (const char* file : {"worlds/cars/orca_1_43.json", "worlds/ethz.json"}) {
    const Outcome checked = gripline_with({"track", road, "--car", source_dir() / file});
    EXPECT_EQ(checked.code, 0) << checked.err;
    EXPECT_THAT(checked.out, HasSubstr("drives it")) << file;
  }
}

/// A road 2 m wide leaves a car of 1.84 m room, but not its front in a bend of 10 m.
TEST_F(CliTrack, ACarWhoseCornersLeaveTheRoadDoesNotSimplyDriveIt) {
  write_text(folder_ / "ring.json", R"({"segments": [{"arc": {"radius": 10, "turn": "360 deg"}}], "half_width": 1})");
  const Outcome checked =
      gripline_with({"track", folder_ / "ring.json", "--car", source_dir() / "worlds/cars/full_size.json"});
  EXPECT_EQ(checked.code, 0) << checked.err;
  EXPECT_THAT(checked.out, AllOf(HasSubstr("1.84 m wide, 4.18 m long, "), HasSubstr("its centre of gravity gets round"),
                                 HasSubstr("one is 0.35 m outside at s = "), Not(HasSubstr("drives it"))));
}

TEST_F(CliTrack, AScaleIsANumberOrARatio) {
  const std::string road = fixture_dir() / "tracks/oval.csv";
  EXPECT_THAT(gripline_with({"track", road, "--scale", "1/43"}).err, HasSubstr("expected a number above 0, or 1:43"));
}

/// A road of 580 m in a survey's file, and the same as one in kilometres that does not say so.
TEST_F(CliTrack, ASurveysTableIsReadAndAnImplausibleSizeIsWarnedOf) {
  const auto survey = [](const std::string& header, double metre) {
    std::string text = header + "\n";
    for (int i = 0; i < 100; ++i) {
      for (const double value : {92 * std::cos(0.0628318531 * i), 92 * std::sin(0.0628318531 * i), 4.0, 4.0})
        text += std::to_string(metre * value) + ";";
      text.back() = '\n';
    }
    return text;
  };
  write_text(folder_ / "feet.csv", survey("East (ft);North (ft);Width right [ft];Width left [ft]", 1 / 0.3048));
  const Outcome feet = gripline_with({"track", folder_ / "feet.csv"});
  EXPECT_EQ(feet.code, 0) << feet.err;
  EXPECT_THAT(feet.out, HasSubstr("8 to 8 m"));
  EXPECT_THAT(feet.err, AllOf(HasSubstr("columns separated by semicolons"), HasSubstr("x from East (ft), "),
                              Not(HasSubstr("warning"))));
  write_text(folder_ / "small.csv", survey("x;y;right;left", 1e-3));
  const Outcome small = gripline_with({"track", folder_ / "small.csv"});
  EXPECT_THAT(small.err, AllOf(HasSubstr("warning: "), HasSubstr("are its numbers kilometres?")));
  EXPECT_THAT(gripline_with({"track", folder_ / "small.csv", "--scale", "1000"}).err, Not(HasSubstr("warning")));
}

TEST_F(CliTrack, TrackMakesFoldersAndTakesUnits) {
  write_text(folder_ / "line.csv", [] {
    std::string text = "x_m,y_m\n";
    for (int i = 0; i < 60; ++i)
      text += std::to_string(50 * std::cos(0.1047197551 * i)) + "," + std::to_string(50 * std::sin(0.1047197551 * i)) +
              "\n";
    return text;
  }());
  for (const char* width : {"9m", "9 m", "900 cm", "9"}) {
    const Outcome outcome = gripline_with({"track", folder_ / "line.csv", "--width", width});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("9 to 9 m")) << width;
  }
  EXPECT_THAT(gripline_with({"track", folder_ / "line.csv", "--width", "9 s"}).err, HasSubstr("expected a length"));
  EXPECT_THAT(gripline_with({"track", folder_ / "line.csv", "--width", "-9 m"}).err, HasSubstr("a length above 0 m"));
  const Outcome made =
      gripline_with({"track", folder_ / "line.csv", "--width", "9m", "--out", folder_ / "new/deep/road.csv"});
  EXPECT_EQ(made.code, 0) << made.err;
  EXPECT_TRUE(fs::exists(folder_ / "new/deep/road.csv"));
  // Points of a road that is written as JSON would lie where those that are read do.
  const std::string before = contents(folder_ / "new/deep/road.csv");
  const Outcome over = gripline_with({"track", folder_ / "new/deep/road.csv", "--out", folder_ / "new/deep/road.json"});
  EXPECT_EQ(over.code, 2);
  EXPECT_THAT(over.err,
              HasSubstr("road.csv: is an input of this command and would be overwritten; choose another file"));
  EXPECT_EQ(contents(folder_ / "new/deep/road.csv"), before);
  // So would those of a road in JSON, which names its points.
  write_text(folder_ / "new/deep/named.json", R"({"centre": "road.csv"})");
  const Outcome named =
      gripline_with({"track", folder_ / "new/deep/named.json", "--scale", "2", "--out", folder_ / "new/deep/road.csv"});
  EXPECT_EQ(named.code, 2);
  EXPECT_THAT(named.err,
              HasSubstr("road.csv: is an input of this command and would be overwritten; choose another file"));
  EXPECT_EQ(contents(folder_ / "new/deep/road.csv"), before);
}

TEST_F(CliTrack, TrackNamesTheRadiusThatARoadStates) {
  for (const auto& [road, radius] : {std::pair{"hill", 22.0}, {"street", 14.0}, {"ring", 25.0}}) {
    const Outcome outcome = gripline_with({"track", source_dir() / "worlds/tracks" / (road + std::string(".json"))});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const std::string found = outcome.out.substr(outcome.out.find("sharpest bend     radius ") + 25);
    EXPECT_NEAR(std::stod(found), radius, 0.01 * radius) << road;
  }
}

TEST_F(CliTrack, TrackWarnsOfCurvaturePeaksThatSmoothingTakesAway) {
  write_text(folder_ / "peak.csv", circle_with_a_point_at(100.8));
  const Outcome raw = gripline_with({"track", folder_ / "peak.csv", "--width", "9.5"});
  EXPECT_EQ(raw.code, 0) << raw.err;
  EXPECT_THAT(raw.err, HasSubstr("if they are noise: --smooth METRES"));
  const Outcome smooth = gripline_with({"track", folder_ / "peak.csv", "--width", "9.5", "--smooth", "1"});
  EXPECT_THAT(smooth.err, Not(HasSubstr("curvature peaks")));
}

TEST_F(CliTrack, TrackReplacesNoPointsThatItDidNotWrite) {
  const std::string oval = fixture_dir() / "tracks/oval.csv";
  const Outcome made = gripline_with({"track", oval, "--out", folder_ / "road.json"});
  EXPECT_EQ(made.code, 0) << made.err;
  EXPECT_THAT(made.out, AllOf(HasSubstr("road.json\n"), HasSubstr("road.csv\n")));
  EXPECT_EQ(gripline_with({"track", oval, "--scale", "2", "--out", folder_ / "road.json"}).code, 0);
  write_text(folder_ / "other.csv", "t,x\n");
  const Outcome foreign = gripline_with({"track", oval, "--out", folder_ / "other.json"});
  EXPECT_EQ(foreign.code, 2);
  EXPECT_THAT(foreign.err, HasSubstr("other.csv, which is another file; remove that or choose another name"));
  EXPECT_EQ(contents(folder_ / "other.csv"), "t,x\n");
}

/// A bend that is too sharp for its width needs smoothing; one that is scaled to millimetres does not.
TEST_F(CliTrack, TrackProposesSmoothingOnlyWhereTheLineIsWrong) {
  write_text(folder_ / "noise.csv", circle_with_a_point_at(103.0));
  const auto refusal = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "track");
    const Outcome outcome = gripline_with(words);
    EXPECT_EQ(outcome.code, 2) << outcome.out;
    return outcome.err;
  };
  EXPECT_THAT(refusal({folder_ / "noise.csv", "--width", "20"}), HasSubstr("if that is noise: --smooth"));
  EXPECT_THAT(refusal({folder_ / "noise.csv", "--width", "20", "--scale", "1000"}), Not(HasSubstr("--smooth")));
  const std::string oval = fixture_dir() / "tracks/oval.csv";
  EXPECT_THAT(refusal({oval, "--scale", "1000"}), AllOf(HasSubstr("millimetres?"), Not(HasSubstr("--smooth"))));
  EXPECT_THAT(refusal({oval, "--car", source_dir() / "worlds/cars/full_size.json"}),
              HasSubstr("full_size.json: the car is"));
}

/// Half widths of 40 m on a lap of 414 m are no noise.
TEST_F(CliTrack, TrackDoubtsWidthsThatNoSmoothingWouldFit) {
  std::string text = "x_m,y_m,w_tr_right_m,w_tr_left_m\n";
  for (int i = 0; i < 200; ++i)
    text += std::to_string(80 * std::cos(0.0314159265 * i)) + "," + std::to_string(50 * std::sin(0.0314159265 * i)) +
            ",40,40\n";
  write_text(folder_ / "wide.csv", text);
  const Outcome outcome = gripline_with({"track", folder_ / "wide.csv"});
  EXPECT_EQ(outcome.code, 2) << outcome.out;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("are the widths metres?"), Not(HasSubstr("--smooth"))));
}

TEST_F(CliTrack, TrackSaysWhatIsLeftOutOfWhatItWrites) {
  write_text(folder_ / "walls.json", R"({"segments": [{"arc": {"radius": 40, "turn": "360 deg"}}], "half_width": 3,
             "walls": {"left": 1}, "start": {"x": 0, "y": 80, "yaw": "180 deg"}})");
  EXPECT_EQ(gripline_with({"track", folder_ / "walls.json"}).err, "");
  const Outcome csv = gripline_with({"track", folder_ / "walls.json", "--out", folder_ / "round.csv"});
  EXPECT_THAT(csv.err, AllOf(HasSubstr("add them to the file as they were"), HasSubstr("a CSV has none")));
  const Outcome json =
      gripline_with({"track", folder_ / "walls.json", "--scale", "1:2", "--reverse", "--out", folder_ / "turned.json"});
  EXPECT_THAT(json.err, AllOf(HasSubstr("with its own stations"), Not(HasSubstr("start"))));
  EXPECT_THAT(contents(folder_ / "turned.json"), HasSubstr("\"y\": 40"));
}

TEST_F(CliTrack, TrackSaysWhatItCannotRead) {
  const std::string oval = fixture_dir() / "tracks/oval.csv", open = fixture_dir() / "tracks/open.csv";
  const auto refused = [](std::vector<std::string> words, const std::string& why) {
    words.insert(words.begin(), "track");
    const Outcome outcome = gripline_with(words);
    EXPECT_EQ(outcome.code, 2) << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr(why));
  };
  refused({}, "needs one road or its two edges");
  refused({open}, "--close METRES closes it");
  refused({oval, "--scale", "1:x"}, "expected a number above 0");
  refused({oval, "--picture", "road.png"}, "ends in .svg");
  refused({oval, "--car", source_dir() / "worlds/cars/full_size.json"}, "the car is");
  refused({fixture_dir() / "tracks/crosses_itself.csv"}, "crosses or overlaps itself");
}

}  // namespace test_cli_track
}  // namespace gripline
