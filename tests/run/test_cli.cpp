// The commands as users call them: what they print, write and end with.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <clocale>

#include "csv.hpp"
#include "program.hpp"

namespace gripline {
namespace {

using testing::AllOf;
using testing::Each;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using namespace testing_support;
namespace fs = std::filesystem;

class Cli : public testing::Test {
 protected:
  Outcome compare(std::vector<std::string> words, const Call& call = {}) const {
    words.insert(words.begin(), {"compare", "experiments/good.json"});
    return gripline_with(words, call);
  }
  std::string out(const std::string& name = "out") const { return folder_ / name; }
  Folder folder_;
};

TEST_F(Cli, HelpAndVersion) {
  const Outcome help = gripline_with({"--help"});
  EXPECT_EQ(help.code, 0);
  for (const char* word : {"compare", "run", "validate", "plugins", "exit: 0 good, 1 a claim failed, 2 your input"})
    EXPECT_THAT(help.out, HasSubstr(word));
  EXPECT_EQ(gripline_with({"compare", "--help"}).code, 0);
  EXPECT_THAT(gripline_with({"compare", "--help"}).out,
              AllOf(HasSubstr("--only"), HasSubstr("--set"), HasSubstr("--plugins"), HasSubstr("--out"),
                    HasSubstr("--force"), HasSubstr("-j")));
  EXPECT_THAT(gripline_with({"run", "--help"}).out, AllOf(HasSubstr("--stack"), HasSubstr("--seed")));
  const Outcome version = gripline_with({"--version"});
  EXPECT_EQ(version.code, 0);
  EXPECT_EQ(version.out, "gripline 0.1.0 (plugin ABI 1)\n");
  const Outcome nothing = gripline_with({});
  EXPECT_EQ(nothing.code, 2);
  EXPECT_THAT(nothing.err, HasSubstr("usage: gripline COMMAND"));
}

TEST_F(Cli, PluginsAreListedAndDescribed) {
  const Outcome list = gripline_with({"plugins", "list"});
  EXPECT_EQ(list.code, 0);
  EXPECT_THAT(list.out, AllOf(HasSubstr("vehicle    dynamic"), HasSubstr("estimator  oracle *"),
                              HasSubstr("* is told the truth"), Not(HasSubstr("unusable"))));
  const Outcome pure_pursuit = gripline_with({"plugins", "describe", "pure_pursuit"});
  EXPECT_EQ(pure_pursuit.code, 0);
  EXPECT_THAT(pure_pursuit.out, AllOf(HasSubstr("controller pure_pursuit"), HasSubstr("horizon [1] = 40  [2, 500]")));
  EXPECT_THAT(gripline_with({"plugins", "describe", "oracle"}).out, HasSubstr("needs the truth"));
  const Outcome missing = gripline_with({"plugins", "describe", "pure_persuit"});
  EXPECT_EQ(missing.code, 3);
  EXPECT_EQ(missing.err, "no plugin \"pure_persuit\"; did you mean \"pure_pursuit\"?\n");
}

TEST_F(Cli, CompareRacesEveryStackAndSeedAndPrintsTheTable) {
  const Outcome outcome = compare({"--out", out()});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("slow"), HasSubstr("told *"), HasSubstr("claims: 1 of 1 hold"),
                                 HasSubstr("results: " + out())));
  for (const char* stack : {"slow", "told"})
    for (const char* seed : {"1", "2"})
      for (const char* file : {"config.json", "steps.csv", "summary.json", "timing.csv"})
        EXPECT_TRUE(fs::exists(folder_ / ("out/" + std::string(stack) + "/" + seed + "/" + file)))
            << stack << seed << file;
  EXPECT_EQ(lines(out() + "/runs.csv").size(), 5u);
  EXPECT_EQ(lines(out() + "/table.csv").size(), 3u);
  EXPECT_TRUE(parse_file(out() + "/claims.json").find("claims")->array().at(0).find("holds")->boolean());
  for (const auto& entry : fs::recursive_directory_iterator(out()))
    EXPECT_THAT(entry.path().filename().string(), Not(HasSubstr(".partial"))) << entry.path();
}

TEST_F(Cli, AFailedClaimIsExitCodeOne) {
  const Outcome outcome = compare({"--out", out(), "--set", "/claims/0=told.violation_s < -1"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("claims: 0 of 1 hold"),
                                 HasSubstr("FAILS    told.violation_s < -1   (0 against -1, 0 of 2 runs)")));
}

TEST_F(Cli, OnlySomeRowsAndSkippedClaims) {
  const Outcome outcome = compare({"--out", out(), "--only", "slow"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_FALSE(fs::exists(out() + "/told"));
  EXPECT_EQ(lines(out() + "/table.csv").size(), 2u);
  EXPECT_THAT(outcome.out, HasSubstr("skipped  told.violation_s <= slow.violation_s   (a row was left out by --only)"));
  const Outcome both = compare({"--out", out(), "--only", "told,slow"});
  EXPECT_THAT(both.out, AllOf(HasSubstr("2 of 4 runs were already there"), HasSubstr("claims: 1 of 1 hold")));
}

/// Same inputs, same bytes: run after run, one at a time or two at a time.
TEST_F(Cli, RunsAreTheSameBytesHoweverTheyAreRaced) {
  ASSERT_EQ(compare({"--out", out("a")}).code, 0);
  ASSERT_EQ(compare({"--out", out("b"), "-j", "2"}).code, 0);
  int compared = 0;
  for (const auto& entry : fs::recursive_directory_iterator(out("a"))) {
    const fs::path relative = fs::relative(entry.path(), out("a"));
    const std::string name = relative.filename().string();
    const bool timed = name == "timing.csv" || name == "runs.csv" || name == "table.csv" || name.ends_with(".html");
    if (entry.is_directory() || timed || name == "claims.json" || relative.begin()->string() == ".cache") continue;
    EXPECT_EQ(contents(entry.path()), contents(out("b") / relative)) << relative;
    ++compared;
  }
  EXPECT_GE(compared, 4 * 4);
}

TEST_F(Cli, FinishedRunsAreKeptAndForceBeginsAgain) {
  ASSERT_EQ(compare({"--out", out()}).code, 0);
  const std::string before = contents(out() + "/slow/1/timing.csv");
  EXPECT_THAT(compare({"--out", out()}).out, HasSubstr("4 of 4 runs were already there."));
  EXPECT_EQ(contents(out() + "/slow/1/timing.csv"), before);
  const Outcome other = compare({"--out", out(), "--set", "/base/mu_init=0.9"});
  EXPECT_EQ(other.code, 2);
  EXPECT_EQ(other.err, out() + " already holds another experiment; choose another --out, or --force to replace it\n");
  const Outcome forced = compare({"--out", out(), "--set", "/base/mu_init=0.9", "--force"});
  EXPECT_EQ(forced.code, 0);
  EXPECT_THAT(forced.out, Not(HasSubstr("already there")));
}

TEST_F(Cli, WithoutOutResultsAreUnderTheExperimentsName) {
  const Call here = {folder_.path(), {}};
  const Outcome outcome =
      gripline_with({"compare", std::string(GRIPLINE_FIXTURE_DIR) + "/experiments/good.json"}, here);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(fs::exists(folder_ / "out/good/table.csv"));
}

/// config.json is the whole run: given back, it gives the same bytes.
TEST_F(Cli, ConfigJsonReproducesItsRun) {
  const Outcome first =
      gripline_with({"run", "experiments/good.json", "--stack", "told", "--seed", "7", "--out", out("a"), "--set",
                     R"(/world/sensors={"sigma": {"x": "2 mm", "yaw_rate": 0.05}})"});
  ASSERT_EQ(first.code, 0) << first.err;
  EXPECT_TRUE(fs::exists(out("a") + "/told/7/steps.csv"));
  EXPECT_FALSE(fs::exists(out("a") + "/slow"));
  const Call elsewhere = {folder_.path(), {}};
  const Outcome again = gripline_with({"run", out("a") + "/told/7/config.json", "--out", out("b")}, elsewhere);
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(contents(out("a") + "/told/7/steps.csv"), contents(out("b") + "/told/7/steps.csv"));
  EXPECT_EQ(contents(out("a") + "/told/7/config.json"), contents(out("b") + "/told/7/config.json"));
  // And the seed matters.
  const Outcome other =
      gripline_with({"run", out("a") + "/told/7/config.json", "--seed", "8", "--out", out("c")}, elsewhere);
  ASSERT_EQ(other.code, 0) << other.err;
  EXPECT_NE(contents(out("a") + "/told/7/steps.csv"), contents(out("c") + "/told/8/steps.csv"));
}

/// The pointers that other programs use.
TEST_F(Cli, SetActsOnTheExpandedExperiment) {
  const auto column = [&](const std::string& set, const char* name) {
    const Outcome outcome =
        gripline_with({"run", "experiments/good.json", "--stack", "slow", "--out", out(), "--force", "--set", set});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return read_csv(out() + "/slow/1/steps.csv").column(name);
  };
  EXPECT_THAT(column(R"(/world/friction=[{"t": 0, "factor": 0.5}])", "mu_true"),
              Each(testing::DoubleNear(0.5 * 0.909227, 1e-6)));
  EXPECT_THAT(column(R"(/world/plant/params={"Df": 0.096, "Dr": 0.08685})", "mu_true"),
              Each(testing::DoubleNear(0.5 * 0.909227, 1e-6)));
  EXPECT_THAT(column("/base/mu_init=0.7", "mu_belief_front"), Each(0.7));
  EXPECT_EQ(column("/world/duration=0.4 s", "t_s").back(), 0.4);
}

/// A locale with decimal commas changes nothing.
TEST_F(Cli, DecimalCommasOfTheLocaleChangeNothing) {
  const char* found = nullptr;
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "fr_FR.utf8", "nl_NL.UTF-8"})
    if (std::setlocale(LC_ALL, name) != nullptr && *std::localeconv()->decimal_point == ',') found = name;
  std::setlocale(LC_ALL, "C");
  const std::string locale = found != nullptr ? found : "de_DE.UTF-8";
  const Outcome plain = compare({"--out", out("a")}, {GRIPLINE_FIXTURE_DIR, {{"LC_ALL", "C"}}});
  const Outcome commas = compare({"--out", out("b")}, {GRIPLINE_FIXTURE_DIR, {{"LC_ALL", locale}}});
  ASSERT_EQ(plain.code, 0);
  ASSERT_EQ(commas.code, 0) << commas.err;
  EXPECT_EQ(contents(out("a") + "/slow/1/steps.csv"), contents(out("b") + "/slow/1/steps.csv"));
  EXPECT_EQ(contents(out("a") + "/slow/1/config.json"), contents(out("b") + "/slow/1/config.json"));
  EXPECT_THAT(commas.out, Not(testing::ContainsRegex("[0-9],[0-9]")));
  if (found == nullptr) GTEST_SKIP() << "no locale with decimal commas is installed here";
}

TEST_F(Cli, OutputMayBePipedAway) {
  const Outcome outcome = run_program({"/bin/sh", "-c", std::string(GRIPLINE_PROGRAM) + " plugins list | true"});
  EXPECT_EQ(outcome.err, "");
}

}  // namespace
}  // namespace gripline
