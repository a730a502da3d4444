// tools/draw_races: a seed says everything of a race, and what it writes are good experiments.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "support/paths.hpp"
#include "support/program.hpp"

namespace gripline {
namespace {

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
  Outcome validate(const std::map<std::string, std::string>& files, const std::string& in) {
    std::vector<std::string> words{"validate"};
    for (const auto& [name, text] : files)
      if (name.starts_with("race_")) words.push_back(folder_.path() / in / name);
    return gripline_with(words);
  }
  Folder folder_;
};

TEST_F(DrawRaces, TheSameSeedDrawsTheSameRacesHoweverMany) {
  const auto two = draw("two", {"7", "2"}), four = draw("four", {"7", "4"}), other = draw("other", {"8", "2"});
  for (const auto& [name, text] : two) {
    ASSERT_TRUE(four.contains(name)) << name;
    EXPECT_EQ(four.at(name), text) << name;
  }
  EXPECT_NE(other.at("race_000.json"), two.at("race_000.json"));
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
  ASSERT_TRUE(files.contains("ring_scaled.csv"));
  EXPECT_THAT(files.at("ring_scaled.csv"), testing::HasSubstr("50.000000,0.000000,2.500000,2.500000"));
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
}

TEST_F(DrawRaces, AFolderWithoutRoadsIsRefused) {
  fs::create_directories(folder_.path() / "empty");
  const Outcome outcome = run_program(
      {source_dir() / "tools/draw_races", "3", "1", folder_.path() / "races", "--roads", folder_.path() / "empty"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, testing::HasSubstr("there is no .csv file in it"));
}

}  // namespace
}  // namespace gripline
