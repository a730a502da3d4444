// gripline diagnose and predict as users call them, on cases that tests/blind makes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <fstream>

#include "support/paths.hpp"
#include "support/program.hpp"
#include "tables/delimited_table.hpp"
#include "util/csv.hpp"

namespace gripline {
namespace test_diagnose_program {

using testing::HasSubstr;
using testing::Not;
using namespace testing_support;
namespace fs = std::filesystem;

const std::string worlds = source_dir().string() + "/worlds/";

Outcome make_cases(const fs::path& out, const std::string& only) {
  return run_program({build_dir() / "tests/blind_cases", out.string(), "--seed", "5", "--count", "1", "--only", only});
}

/// A table with texts in it, row by row.
std::vector<std::map<std::string, std::string>> rows_of(const fs::path& file) {
  const auto cells = [](const std::string& line) {
    std::vector<std::string> out(1);
    for (const char c : line) {
      if (c == ',')
        out.emplace_back();
      else
        out.back() += c;
    }
    return out;
  };
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  const auto header = cells(line);
  std::vector<std::map<std::string, std::string>> rows;
  while (std::getline(in, line)) {
    const auto values = cells(line);
    auto& row = rows.emplace_back();
    for (std::size_t i = 0; i < header.size() && i < values.size(); ++i) row[header[i]] = values[i];
  }
  return rows;
}

/// One case of the 1:43 car per kind, made once.
class DiagnoseProgram : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::path(testing::TempDir()) / ("gripline_diagnose_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    made_ = make_cases(in("blind"), "none_white,single_white,excluded");
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }
  static fs::path in(const std::string& name) { return folder_ / name; }
  static fs::path case_of(const std::string& kind) { return in("blind/cases/" + kind + "_000"); }
  /// Diagnoses the log of a case; `more` follows.
  static Outcome diagnose(const fs::path& one, const std::string& out, std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"diagnose", worlds + "diagnose_rc43.json", (one / "measured.csv").string(),
                                      "--out", in(out).string()};
    if (more.empty()) more = {"--case", (one / "case.json").string()};
    words.insert(words.end(), more.begin(), more.end());
    return gripline_with(words);
  }
  static fs::path track_of(const fs::path& one) {
    const std::string text = contents(one / "case.json");
    const std::size_t at = text.find("rc43_");
    return in("blind/tracks/" + text.substr(at, text.find('"', at) - at));
  }
  static fs::path folder_;
  static Outcome made_;
};
fs::path DiagnoseProgram::folder_;
Outcome DiagnoseProgram::made_;

TEST_F(DiagnoseProgram, CasesAreTheSameForTheSameSeed) {
  ASSERT_EQ(made_.code, 0) << made_.err;
  ASSERT_EQ(make_cases(in("again"), "single_white").code, 0);
  for (const char* file : {"measured.csv", "heldout.csv", "case.json", "answer.json"})
    EXPECT_EQ(contents(in("again/cases/single_white_000") / file), contents(case_of("single_white") / file)) << file;
}

TEST_F(DiagnoseProgram, ScoresAFolderAndItsCarsAreThoseOfTheProtocol) {
  const Outcome scored =
      gripline_with({"diagnose", "--score", in("blind/cases").string(), "--out", in("score").string()});
  ASSERT_EQ(scored.code, 0) << scored.err;
  EXPECT_THAT(scored.out, HasSubstr("nothing missing, white"));
  const auto rows = rows_of(in("score/score.csv"));
  ASSERT_EQ(rows.size(), 3U);
  for (const auto& row : rows) EXPECT_EQ(row.at("right"), "1") << row.at("case");
  // Where nothing is missing the nominal car predicts the exact log up to the rounding of files: two integrators agree.
  EXPECT_LT(std::stod(rows[1].at("error_before")), 0.02);
  // Where something is, its true parameters do.
  EXPECT_LT(std::stod(rows[2].at("error_true")), 0.02);
  EXPECT_GT(std::stod(rows[2].at("error_before")), 0.5);
}

TEST_F(DiagnoseProgram, ExitCodesSayWhatWasFound) {
  const Outcome named = diagnose(case_of("single_white"), "named");
  EXPECT_EQ(named.code, 0) << named.out << named.err;
  EXPECT_THAT(named.out, HasSubstr("named: aero_drag"));
  const Outcome nothing = diagnose(case_of("none_white"), "nothing");
  EXPECT_EQ(nothing.code, 0) << nothing.out;
  EXPECT_THAT(contents(in("nothing/diagnosis.json")), HasSubstr("seen_at"));
  const Outcome unknown = diagnose(case_of("excluded"), "unknown");
  EXPECT_EQ(unknown.code, 1) << unknown.out;
  EXPECT_THAT(unknown.out, HasSubstr("no effect of the catalogue explains"));
}

TEST_F(DiagnoseProgram, SameInputSameBytesWithinItsTimeAndMemory) {
  rusage before{}, after{};
  getrusage(RUSAGE_CHILDREN, &before);
  ASSERT_EQ(diagnose(case_of("single_white"), "one").code, 0);
  getrusage(RUSAGE_CHILDREN, &after);
  const auto seconds = [](const rusage& r) {
    return static_cast<double>(r.ru_utime.tv_sec + r.ru_stime.tv_sec) +
           1e-6 * static_cast<double>(r.ru_utime.tv_usec + r.ru_stime.tv_usec);
  };
  EXPECT_LT(seconds(after) - seconds(before), 5.0);
  EXPECT_LT(after.ru_maxrss, 500'000);  // [kB]
  ASSERT_EQ(diagnose(case_of("single_white"), "two").code, 0);
  for (const char* file : {"diagnosis.json", "augmented_world.json"})
    EXPECT_EQ(contents(in("one") / file), contents(in("two") / file)) << file;
}

TEST_F(DiagnoseProgram, HeldOutLogsMeasureTheGapAndTheAugmentedWorldPredicts) {
  const fs::path one = case_of("single_white");
  ASSERT_EQ(
      diagnose(one, "held", {"--case", (one / "case.json").string(), "--held-out", (one / "heldout.csv").string()})
          .code,
      0);
  const std::string augmented = in("held/augmented_world.json").string();
  EXPECT_EQ(gripline_with({"validate", augmented}).code, 0);
  const auto error = [&](const std::string& world, const std::string& name) {
    const Outcome predicted = gripline_with({"predict", world, (one / "heldout.csv").string(), "--track",
                                             track_of(one).string(), "--out", in(name).string()});
    EXPECT_EQ(predicted.code, 0) << predicted.err;
    const auto table = read_delimited(in(name));
    return table.column[static_cast<std::size_t>(table.find("position_m"))].back();
  };
  EXPECT_LT(error(augmented, "after.csv"), 0.2 * error(worlds + "diagnose_rc43.json", "before.csv"));
}

TEST_F(DiagnoseProgram, AnotherTrackIsRefusedWithOneLine) {
  // The same log on the world's own road.
  const fs::path one = case_of("single_white");
  const Outcome wrong = gripline_with(
      {"diagnose", worlds + "diagnose_rc43.json", (one / "measured.csv").string(), "--out", in("wrong").string()});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("another track; give the right one with --track"));
  EXPECT_EQ(std::count(wrong.err.begin(), wrong.err.end(), '\n'), 1) << wrong.err;
  const Outcome right = diagnose(one, "right", {"--track", track_of(one).string()});
  EXPECT_EQ(right.code, 0) << right.err;
}

TEST_F(DiagnoseProgram, InputThatIsNoneEndsWithTwo) {
  const fs::path one = case_of("single_white");
  EXPECT_EQ(gripline_with({"diagnose"}).code, 2);
  EXPECT_EQ(gripline_with({"diagnose", worlds + "diagnose_rc43.json", in("no.csv").string()}).code, 2);
  const Outcome unknown_effect = [&] {
    std::ofstream(in("case.json")) << "{\"exclude\": [\"aero_dragg\"]}";
    return diagnose(one, "bad", {"--track", track_of(one).string(), "--case", in("case.json").string()});
  }();
  EXPECT_EQ(unknown_effect.code, 2);
  EXPECT_THAT(unknown_effect.err, HasSubstr("did you mean \"aero_drag\"?"));
}

/// A world that the diagnosis has no room for is refused before anything is driven.
TEST_F(DiagnoseProgram, AnExperimentOfTooManyHiddenStatesIsNotDriven) {
  std::ofstream(in("states.json"))
      << "{\"extends\": \"" << worlds << "diagnose_rc43.json\", \"plant\": {\"effects\": ["
      << R"({"plugin": "relaxation"}, {"plugin": "relaxation"}, {"plugin": "steer_lag"}]}})";
  const Outcome refused =
      gripline_with({"compare", source_dir() / "experiments/diagnose/hidden_1_43.json", "--set",
                     "/nominal=\"" + in("states.json").string() + "\"", "--out", in("states").string()});
  EXPECT_EQ(refused.code, 2) << refused.err;
  EXPECT_THAT(refused.err, HasSubstr("states.json:1:"));
  EXPECT_THAT(
      refused.err,
      HasSubstr("/plant/effects: these effects have 5 hidden states (relaxation 2, relaxation 2, steer_lag 1)"));
  EXPECT_FALSE(fs::exists(in("states/drag"))) << "driven before it was read";
}

/// An experiment of kind "diagnose", cut to one case.
TEST_F(DiagnoseProgram, AnExperimentDrivesDiagnosesAndJudges) {
  const std::string file = source_dir() / "experiments/diagnose/hidden_1_43.json";
  const std::string drag =
      "/cases={\"drag\": {\"hidden\": {\"plant\": {\"effects\": [{\"plugin\": \"aero_drag\", \"params\": {\"a\": "
      "0.4}}]}}, "
      "\"missing\": [[\"aero_drag\"]], \"round_trip\": true}, \"other\": {\"hidden\": {}}}";
  const auto compare = [&](const std::string& claims, const std::string& out, const std::string& only = "drag") {
    return gripline_with(
        {"compare", file, "--only", only, "--set", drag, "--set", "/claims=" + claims, "--out", in(out).string()});
  };
  const Outcome good = compare(
      "[\"drag.right == 1\", \"drag.round_trip == 1\", \"drag.closure >= 0.95\", \"other.unknown == 1\"]", "e1");
  EXPECT_EQ(good.code, 0) << good.out << good.err;
  EXPECT_THAT(good.out, HasSubstr("drag: named: aero_drag"));
  EXPECT_TRUE(fs::exists(in("e1/drag/augmented_world.json")));
  EXPECT_EQ(rows_of(in("e1/diagnoses.csv")).front().at("round_trip"), "1");
  for (const char* page : {"e1/report.html", "e1/drag/report.html"}) EXPECT_TRUE(fs::exists(in(page))) << page;
  EXPECT_THAT(contents(in("e1/drag/report.html")), HasSubstr("<title>drag of hidden_1_43 "));
  EXPECT_THAT(contents(in("e1/claims.json")), HasSubstr("drag.round_trip == 1"));
  EXPECT_EQ(compare("[\"drag.unknown == 1\"]", "e2").code, 1);
  const Outcome bad = compare("[\"drag.rihgt == 1\"]", "e3");
  EXPECT_EQ(bad.code, 2);
  EXPECT_THAT(bad.err, HasSubstr("did you mean \"right\"?"));
  EXPECT_FALSE(fs::exists(in("e3/drag"))) << "driven before it was read";
  // The case that --only left out was not driven, and the claim about it is skipped.
  EXPECT_FALSE(fs::exists(in("e1/other")));
  EXPECT_THAT(good.out, HasSubstr("skipped other.unknown == 1: a case was left out by --only"));
  const Outcome none = compare("[]", "e4", "drga");
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.err, HasSubstr("--only: no case \"drga\" in this experiment; did you mean \"drag\"?"));
}

/// A patch of low friction turns the car where its throttle bends: noise measured with the bare car assumed bent
/// commands, and a brake gain stood beside the patch. The car of DiagnoseRig leaves the road: it meets no patch twice.
TEST_F(DiagnoseProgram, APatchIsNoBentThrottle) {
  const std::string patch =
      "/cases={\"patch\": {\"hidden\": {\"plant\": {\"effects\": [{\"plugin\": \"friction_patch\", "
      "\"params\": {\"k\": -0.2, \"s0\": 0.3, \"w\": 0.14}}]}}, \"missing\": [[\"friction_patch\"]]}}";
  const Outcome out =
      gripline_with({"compare", source_dir() / "experiments/diagnose/hidden_1_43.json", "--set", patch, "--set",
                     "/claims=[\"patch.right == 1\", \"patch.closure >= 0.95\"]", "--out", in("patch")});
  EXPECT_EQ(out.code, 0) << out.out << out.err;
  EXPECT_THAT(out.out, HasSubstr("patch: named: friction_patch"));
}

/// 1 % of the readings far off and 2 % of the rows gone: the same name, and the log's health says so.
TEST_F(DiagnoseProgram, OutliersAndDroppedRowsChangeNoName) {
  const fs::path one = case_of("single_white");
  std::ifstream from(one / "measured.csv");
  std::ofstream to(in("dirty.csv"));
  std::string line;
  for (int row = 0; std::getline(from, line); ++row) {
    if (row > 0 && row % 50 == 17) continue;
    if (row > 0 && row % 100 == 31) {  // the speed
      std::size_t at = 0;
      for (int i = 0; i < 4; ++i) at = line.find(',', at) + 1;
      line.replace(at, line.find(',', at) - at, "9.5");
    }
    to << line << '\n';
  }
  to.close();
  const Outcome dirty = gripline_with({"diagnose", worlds + "diagnose_rc43.json", in("dirty.csv").string(), "--case",
                                       (one / "case.json").string(), "--out", in("dirty").string()});
  EXPECT_EQ(dirty.code, 0) << dirty.err;
  EXPECT_THAT(dirty.out, HasSubstr("named: aero_drag"));
  EXPECT_THAT(dirty.out, HasSubstr("log: outliers"));
  EXPECT_THAT(dirty.out, HasSubstr("log: rows"));
}

TEST_F(DiagnoseProgram, TheSameLogTwiceIsOneAndNoHeldOutLog) {
  const fs::path one = case_of("none_white");
  fs::copy_file(one / "measured.csv", in("twin.csv"), fs::copy_options::overwrite_existing);
  const std::string track = track_of(one).string();
  const Outcome twice = diagnose(one, "twice", {in("twin.csv").string(), "--track", track});
  EXPECT_EQ(twice.code, 0) << twice.out << twice.err;
  EXPECT_THAT(twice.out, HasSubstr("nothing_missing"));
  EXPECT_THAT(twice.out, HasSubstr("holds the same rows as measured.csv; used once"));
  const Outcome held = diagnose(one, "held_twin", {"--track", track, "--held-out", in("twin.csv").string()});
  EXPECT_EQ(held.code, 2);
  EXPECT_THAT(held.err, HasSubstr("same rows as the log measured.csv"));
}

TEST_F(DiagnoseProgram, AScorecardOutlivesABadCase) {
  const fs::path folder = in("mixed/cases");
  fs::create_directories(folder);
  fs::copy(in("blind/tracks"), in("mixed/tracks"));
  for (const char* kind : {"none_white", "single_white", "excluded"})
    fs::copy(case_of(kind), folder / kind, fs::copy_options::recursive);
  std::ofstream(folder / "single_white" / "answer.json") << R"({"kind": 3, "effects": []})";
  fs::copy_file(worlds + "diagnose_rc43.json", folder / "excluded" / "case.json", fs::copy_options::overwrite_existing);
  const Outcome mixed = gripline_with({"diagnose", "--score", folder.string(), "--out", in("mixed/out").string()});
  EXPECT_EQ(mixed.code, 2);
  EXPECT_THAT(mixed.out, HasSubstr("1 of 3 cases are in these figures"));
  EXPECT_THAT(mixed.out, Not(HasSubstr("nan")));
  EXPECT_THAT(mixed.err, HasSubstr("/kind: expected a text"));
  EXPECT_THAT(mixed.err, HasSubstr("case.json: is a world, expected a case\n"));
  EXPECT_EQ(rows_of(in("mixed/out/score.csv")).size(), 1U);
  for (const auto& one : fs::directory_iterator(folder)) fs::remove(one.path() / "answer.json");
  const Outcome none = gripline_with({"diagnose", "--score", folder.string(), "--out", in("mixed/none").string()});
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.err, HasSubstr("none of its 3 cases has an answer.json"));
  const Outcome both = gripline_with({"diagnose", "--score", folder.string(), worlds + "diagnose_rc43.json"});
  EXPECT_EQ(both.code, 2);
  EXPECT_THAT(both.err, HasSubstr("--score takes a folder of cases and nothing else"));
}

/// Nor does a case that breaks cost the others their scores: here its results have no place to be written to.
TEST_F(DiagnoseProgram, AScorecardOutlivesACaseThatBreaks) {
  const fs::path folder = in("broken/cases");
  fs::create_directories(folder);
  fs::create_directories(in("broken/out"));
  fs::copy(in("blind/tracks"), in("broken/tracks"));
  for (const char* kind : {"none_white", "single_white"})
    fs::copy(case_of(kind), folder / kind, fs::copy_options::recursive);
  std::ofstream(in("broken/out/none_white")) << "a file";
  const Outcome broken = gripline_with({"diagnose", "--score", folder.string(), "--out", in("broken/out").string()});
  EXPECT_EQ(broken.code, 4);
  EXPECT_THAT(broken.err, HasSubstr("not scored: none_white: "));
  EXPECT_THAT(broken.out, HasSubstr("1 of 2 cases are in these figures"));
  const auto rows = rows_of(in("broken/out/score.csv"));
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows.front().at("case"), "single_white");
  EXPECT_TRUE(fs::exists(in("broken/out/scorecard.txt")));
}

/// Where no case has a score there is no card, and one of an earlier call stays.
TEST_F(DiagnoseProgram, NoScoreReplacesNoScorecard) {
  const fs::path folder = in("unscored/cases"), out = in("unscored/out");
  fs::create_directories(folder);
  fs::create_directories(out);
  fs::copy(in("blind/tracks"), in("unscored/tracks"));
  fs::copy(case_of("none_white"), folder / "none_white", fs::copy_options::recursive);
  std::ofstream(folder / "none_white" / "answer.json") << R"({"kind": 3, "effects": []})";
  std::ofstream(out / "scorecard.txt") << "earlier";
  const Outcome none = gripline_with({"diagnose", "--score", folder.string(), "--out", out.string()});
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.err, HasSubstr("/kind: expected a text"));
  EXPECT_THAT(none.err, HasSubstr("no case has a score: no scorecard is written\n"));
  EXPECT_THAT(none.out, Not(HasSubstr("scores: ")));
  EXPECT_EQ(contents(out / "scorecard.txt"), "earlier");
  EXPECT_FALSE(fs::exists(out / "score.csv"));
}

}  // namespace test_diagnose_program
}  // namespace gripline
