// tools/draw_races: a seed says everything of a race, and what it writes are good experiments.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "geometry/track_file.hpp"
#include "support/paths.hpp"
#include "support/program.hpp"

namespace gripline {
namespace test_draw_races {

namespace fs = std::filesystem;
using namespace testing_support;

/// A start of --poses as its road has it, lengths and speeds at full size; aside and askew are positive to the left.
struct Posed {
  nlohmann::json race;
  double aside = 0.0, to_left = 0.0, to_right = 0.0;  // of the centre line, to the edges [m]
  double askew = 0.0;                                 // [rad]
  double speed = 0.0;                                 // [m/s]
  bool of_pace(const std::string& pace) const {
    return race.at("note").get<std::string>().starts_with(pace + " start");
  }
};

class DrawRaces : public testing::Test {
 protected:
  /// The files that it writes, by name.
  std::map<std::string, std::string> draw(const std::string& into, std::vector<std::string> more) {
    const fs::path folder = folder_.path() / into;
    std::vector<std::string> words{source_dir() / "tools/draw_races"};
    words.insert(words.end(), more.begin(), more.end());
    words.insert(words.begin() + 3, folder);  // SEED COUNT FOLDER
    const Outcome outcome = run_program(words);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    std::map<std::string, std::string> files;
    for (const fs::directory_entry& file : fs::directory_iterator(folder))
      files[file.path().filename()] = contents(file.path());
    return files;
  }
  static int count_races(const std::map<std::string, std::string>& files) {
    return static_cast<int>(
        std::ranges::count_if(files, [](const auto& file) { return file.first.starts_with("race_"); }));
  }
  Outcome validate(const std::map<std::string, std::string>& files, const std::string& in) {
    std::vector<std::string> words{"validate"};
    for (const auto& [name, text] : files)
      if (name.starts_with("race_")) words.push_back(folder_.path() / in / name);
    return gripline_with(words);
  }
  /// A road of a circle around the origin, 10 m wide; the folder that it is in.
  std::string ring(double radius, int points) {
    const fs::path roads = folder_.path() / "roads";
    fs::create_directories(roads);
    std::ofstream road(roads / "ring.csv");
    road << "# x_m,y_m,w_tr_right_m,w_tr_left_m\n";
    for (int i = 0; i < points; ++i) {
      const double angle = 2 * std::numbers::pi * i / points;
      road << radius * std::cos(angle) << ',' << radius * std::sin(angle) << ",5,5\n";
    }
    return roads;
  }
  /// A file of --roads with this text is refused by its name, and nothing is drawn.
  void expect_no_road(const std::string& text, const std::string& expected) const {
    SCOPED_TRACE(text);
    write_text(folder_ / "roads/some.csv", text);
    const Outcome outcome = run_program(
        {source_dir() / "tools/draw_races", "3", "9", folder_.path() / "races", "--roads", folder_ / "roads"});
    EXPECT_EQ(outcome.code, 1);
    EXPECT_THAT(outcome.err, testing::HasSubstr("some.csv: not a road in TU Munich's format; " + expected));
    EXPECT_FALSE(fs::exists(folder_.path() / "races"));
  }
  /// The races drawn into a folder with --poses on roads `scale` times as long as at full size.
  std::vector<Posed> posed(const std::map<std::string, std::string>& files, const std::string& in, double scale) {
    std::vector<Posed> all;
    for (const auto& [name, text] : files) {
      if (!name.starts_with("race_")) continue;
      Posed& one = all.emplace_back(Posed{.race = nlohmann::json::parse(text)});
      const nlohmann::json& start = one.race.at("world").at("start");
      const Pose pose{start.at("x"), start.at("y"), start.at("yaw")};
      const Track road = load_track(folder_.path() / in / one.race.at("world").at("track").get<std::string>());
      const CurveLocation place = road.locate(pose);
      one.aside = place.n / scale;
      one.to_left = (road.half_width_left(place.s) - place.n) / scale;
      one.to_right = (road.half_width_right(place.s) + place.n) / scale;
      one.askew = wrap_angle(pose.yaw - place.yaw);
      one.speed = start.at("speed").get<double>() / std::sqrt(scale);
    }
    return all;
  }
  Folder folder_;
};

TEST_F(DrawRaces, TheSameSeedDrawsTheSameRacesHoweverMany) {
  const auto two = draw("two", {"7", "2"}), four = draw("four", {"7", "4"});
  EXPECT_EQ(count_races(two), 2);
  EXPECT_EQ(count_races(four), 4);
  for (const auto& [name, text] : two) {
    ASSERT_TRUE(four.contains(name)) << name;
    EXPECT_EQ(four.at(name), text) << name;
  }
}

/// The seed of race 0's start, drawn last of all.
int first_seed(const std::map<std::string, std::string>& files) {
  return nlohmann::json::parse(files.at("race_000.json")).at("seeds").at("first");
}

TEST_F(DrawRaces, AnotherSeedScaleOrSizeDrawsOtherRaces) {
  const std::set<int> seeds{first_seed(draw("one", {"7", "1"})), first_seed(draw("other", {"8", "1"})),
                            first_seed(draw("small", {"7", "1", "--scale", "1:43"})),
                            first_seed(draw("shorter", {"7", "1", "--size", "0.8"}))};
  EXPECT_EQ(seeds.size(), 4U);
}

TEST_F(DrawRaces, OneFolderHasRacesOfOneDraw) {
  (void)draw("races", {"7", "1"});
  const Outcome again = run_program({source_dir() / "tools/draw_races", "8", "1", folder_.path() / "races"});
  EXPECT_EQ(again.code, 2);
  EXPECT_THAT(again.err, testing::HasSubstr("races is not empty; expected a new folder"));
}

TEST_F(DrawRaces, NumbersThatMakeNoRaceAreRefused) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> wrong{
      {{"7", "0"}, "0: expected 1 to 10000 races"},
      {{"7", "1", "--size", "0"}, "0: expected a number above 0"},
      {{"7", "1", "--size", "nan"}, "nan: expected a number above 0"},
      {{"7", "1", "--duration", "-3"}, "-3: expected a number above 0"}};
  for (const auto& [given, expected] : wrong) {
    std::vector<std::string> words{source_dir() / "tools/draw_races"};
    words.insert(words.end(), given.begin(), given.end());
    words.insert(words.begin() + 3, folder_.path() / "none");
    const Outcome outcome = run_program(words);
    EXPECT_EQ(outcome.code, 2) << expected;
    EXPECT_THAT(outcome.err, testing::HasSubstr(expected));
    EXPECT_FALSE(fs::exists(folder_.path() / "none"));
  }
}

TEST_F(DrawRaces, EveryKindIsAGoodExperimentAtBothScales) {
  for (const std::string scale : {"full", "1:43"})
    for (const std::string kind : {"constant", "fade", "drop", "drops", "rise", "wave", "wet"}) {
      const std::string into = kind + scale.back();
      const auto files = draw(into, {"1", "1", "--scale", scale, "--kind", kind});
      const Outcome outcome = validate(files, into);
      EXPECT_EQ(outcome.code, 0) << scale << " " << kind << outcome.out << outcome.err;
      EXPECT_EQ(files.at("race_000.json").find("patches") != std::string::npos, kind == "wet") << kind;
    }
}

TEST_F(DrawRaces, PosesOfASeedAreTheSameHoweverMany) {
  const auto two = draw("two", {"7", "2", "--poses"}), four = draw("four", {"7", "4", "--poses"});
  EXPECT_EQ(count_races(four), 4);
  for (const auto& [name, text] : two) {
    ASSERT_TRUE(four.contains(name)) << name;
    EXPECT_EQ(four.at(name), text) << name;
  }
}

TEST_F(DrawRaces, PosesAreBesideTheLineAndAskewOnTheRoadAtBothScales) {
  for (const auto& [scale, length] : {std::pair<std::string, double>{"full", 1.0}, {"1:43", 1.0 / 43}}) {
    const std::string into = std::string("poses") + scale.back();
    const auto files = draw(into, {"1", "16", "--poses", "--scale", scale});
    const Outcome outcome = validate(files, into);
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    std::map<std::string, int> seen;
    for (const Posed& one : posed(files, into, length)) {
      SCOPED_TRACE(one.race.at("note").get<std::string>());
      EXPECT_LE(std::abs(one.aside), 4.001);
      EXPECT_GE(std::min(one.to_left, one.to_right), 1.499);
      // The tool's direction of the road is that of 8 m of it: 5 degrees off where a radius of 11 m begins.
      EXPECT_LE(std::abs(one.askew), (30 + 6) * std::numbers::pi / 180);
      EXPECT_GE(one.speed, 0.0999);
      EXPECT_LE(one.speed, 20.001);
      for (const char* pace : {"standing", "slow", "fast"}) seen[pace] += one.of_pace(pace) ? 1 : 0;
      if (one.of_pace("standing")) {
        EXPECT_NEAR(one.speed, 0.1, 1e-4);
      }
    }
    EXPECT_THAT(seen, testing::Each(testing::Pair(testing::_, testing::Gt(1)))) << scale;
    EXPECT_EQ(seen["standing"] + seen["slow"] + seen["fast"], 16);
  }
}

TEST_F(DrawRaces, PosesAreRacedOnceAndWithoutChangingFriction) {
  const auto full = draw("full", {"1", "1", "--poses"}),
             small = draw("small", {"1", "1", "--poses", "--scale", "1:43"});
  const auto brief = draw("brief", {"1", "1", "--poses", "--duration", "3"});
  for (const auto& [files, duration] : {std::pair{full, 16.0}, {small, 5.0}, {brief, 3.0}}) {
    const auto race = nlohmann::json::parse(files.at("race_000.json"));
    EXPECT_EQ(race.at("world").at("duration"), duration);
    EXPECT_TRUE(race.at("world").at("friction").is_null());
    EXPECT_TRUE(race.at("perturb").is_null());
    EXPECT_EQ(race.at("seeds").at("count"), 1);
  }
}

TEST_F(DrawRaces, PosesLeaveRoomToBrakeAndTurn) {
  const double radius = 50, g = 9.81;
  const auto files = draw("races", {"3", "40", "--poses", "--roads", ring(radius, 300)});
  double fastest = 0.0;
  for (const Posed& one : posed(files, "races", 1.0)) {
    if (!one.race.at("note").get<std::string>().ends_with("_ring, times 1, drawn by tools/draw_races from 3")) continue;
    fastest = std::max(fastest, one.speed);
    EXPECT_LE(one.speed, 1.01 * std::sqrt(0.6 * g * radius));
    const double turn = one.speed * one.speed / (0.5 * g) * (1 - std::cos(one.askew));
    EXPECT_LE(turn + 1.2, one.askew > 0 ? one.to_left : one.to_right) << one.speed << " " << one.askew;
  }
  EXPECT_GT(fastest, 0.6 * std::sqrt(0.6 * g * radius));
}

/// The car stays as large as it is.
TEST_F(DrawRaces, PosesOnSmallerRoadsAreAsFarFromTheEdge) {
  const auto files = draw("half", {"1", "12", "--poses", "--size", "0.5"});
  const std::vector<Posed> drawn = posed(files, "half", 0.5);
  ASSERT_EQ(drawn.size(), 12u);
  for (const Posed& one : drawn) EXPECT_GE(0.5 * std::min(one.to_left, one.to_right), 1.49);
}

TEST_F(DrawRaces, PosesHaveNoKindOfFriction) {
  const Outcome outcome =
      run_program({source_dir() / "tools/draw_races", "7", "1", folder_.path() / "none", "--poses", "--kind", "wet"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, testing::HasSubstr("argument --kind: not allowed with argument --poses"));
  EXPECT_FALSE(fs::exists(folder_.path() / "none"));
}

TEST_F(DrawRaces, RoadsOfAFolderAreRacedInTheirSize) {
  const auto files = draw("races", {"3", "12", "--size", "0.5", "--roads", ring(100, 120)});
  const auto ring = std::ranges::find_if(files, [](const auto& file) { return file.first.ends_with("_ring.csv"); });
  ASSERT_NE(ring, files.end());
  EXPECT_THAT(ring->second, testing::HasSubstr("50.000000,0.000000,2.500000,2.500000"));
  EXPECT_EQ(ring->first.substr(0, 5), "road_");
  const Outcome outcome = validate(files, "races");
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
}

TEST_F(DrawRaces, AFileThatIsNoRoadIsRefused) {
  expect_no_road("lap,time\n1,93.2\n", "expected lines of x, y");
  expect_no_road("# x_m,y_m,w_tr_right_m,w_tr_left_m\n", "expected three or more");
  expect_no_road("1,2,5,5\n1,2,5,5\n1,2,5,5\n1,2,5,5\n", "expected three or more");
}

TEST_F(DrawRaces, AFolderWithoutRoadsIsRefused) {
  fs::create_directories(folder_.path() / "empty");
  const Outcome outcome = run_program(
      {source_dir() / "tools/draw_races", "3", "1", folder_.path() / "races", "--roads", folder_.path() / "empty"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, testing::HasSubstr("there is no .csv file in it"));
}

}  // namespace test_draw_races
}  // namespace gripline
