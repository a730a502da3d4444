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

#include "support/paths.hpp"
#include "support/program.hpp"

namespace gripline {
namespace test_draw_races {

namespace fs = std::filesystem;
using namespace testing_support;

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

TEST_F(DrawRaces, RoadsOfAFolderAreRacedInTheirSize) {
  fs::create_directories(folder_.path() / "roads");
  std::ofstream road(folder_.path() / "roads/ring.csv");
  road << "# x_m,y_m,w_tr_right_m,w_tr_left_m\n";
  for (int i = 0; i < 120; ++i) {
    const double angle = 2 * std::numbers::pi * i / 120;
    road << 100 * std::cos(angle) << ',' << 100 * std::sin(angle) << ",5,5\n";
  }
  road.close();
  const auto files = draw("races", {"3", "12", "--size", "0.5", "--roads", folder_.path() / "roads"});
  const auto ring = std::ranges::find_if(files, [](const auto& file) { return file.first.ends_with("_ring.csv"); });
  ASSERT_NE(ring, files.end());
  EXPECT_THAT(ring->second, testing::HasSubstr("50.000000,0.000000,2.500000,2.500000"));
  EXPECT_EQ(ring->first.substr(0, 5), "road_");
  const Outcome outcome = validate(files, "races");
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
}

TEST_F(DrawRaces, AFileThatIsNoRoadIsRefused) {
  write_text(folder_ / "roads/lap_times.csv", "lap,time\n1,93.2\n");
  const Outcome outcome = run_program(
      {source_dir() / "tools/draw_races", "3", "9", folder_.path() / "races", "--roads", folder_ / "roads"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err,
              testing::HasSubstr("lap_times.csv: not a road in TU Munich's format; expected lines of x, y"));
  EXPECT_FALSE(fs::exists(folder_.path() / "races"));
}

TEST_F(DrawRaces, ARoadOfNoPointsIsRefused) {
  write_text(folder_ / "roads/empty.csv", "# x_m,y_m,w_tr_right_m,w_tr_left_m\n");
  const Outcome outcome = run_program(
      {source_dir() / "tools/draw_races", "3", "9", folder_.path() / "races", "--roads", folder_ / "roads"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, testing::HasSubstr("empty.csv: not a road in TU Munich's format; expected three or more"));
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
