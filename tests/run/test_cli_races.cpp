// Races as users call them: what compare and run print, keep, write and end with.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <sstream>

#include "experiment/column_docs.hpp"
#include "experiment/out_folder.hpp"
#include "support/race_program.hpp"
#include "util/csv.hpp"

namespace gripline {
namespace test_cli_races {

using testing::AllOf;
using testing::Each;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using namespace testing_support;
namespace fs = std::filesystem;

class CliRaces : public RaceProgram {};

TEST_F(CliRaces, CompareRacesEveryStackAndSeedAndPrintsTheTable) {
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

/// Whatever -j the call has that finds them.
TEST_F(CliRaces, ClaimsOnTimesAreJudgedOnRunsThatWereDrivenAlone) {
  const auto judged = [&](const std::string& name, const char* jobs) {
    const Outcome outcome = compare({"--out", out(name), "-j", jobs, "--set", "/claims/0=told.solve_ms_median < 1e6"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.out;
  };
  const std::string skipped = "skipped  told.solve_ms_median < 1e6   (on times: needs -j 1)";
  EXPECT_THAT(judged("beside", "2"), AllOf(HasSubstr(skipped), Not(HasSubstr("from earlier calls"))));
  EXPECT_THAT(judged("beside", "1"),
              AllOf(HasSubstr("4 of 4 runs were already there."), HasSubstr(skipped),
                    HasSubstr("Times of runs from earlier calls were not measured with -j 1; --force or another --out "
                              "drives them again.\n")));
  EXPECT_THAT(judged("alone", "1"), HasSubstr("claims: 1 of 1 hold"));
  EXPECT_THAT(judged("alone", "2"), HasSubstr("claims: 1 of 1 hold"));
}

TEST_F(CliRaces, AFailedClaimIsExitCodeOne) {
  const Outcome outcome = compare({"--out", out(), "--set", "/claims/0=told.violation_s < -1"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("claims: 0 of 1 hold"),
                                 HasSubstr("FAILS    told.violation_s < -1   (0 against -1, 0 of 1 runs)")));
}

TEST_F(CliRaces, OnlySomeRowsAndSkippedClaims) {
  const Outcome outcome = compare({"--out", out(), "--only", "slow"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_FALSE(fs::exists(out() + "/told"));
  EXPECT_EQ(lines(out() + "/table.csv").size(), 2u);
  EXPECT_THAT(outcome.out, HasSubstr("skipped  told.violation_s <= slow.violation_s   (a row was left out by --only)"));
  const Outcome both = compare({"--out", out(), "--only", "told,slow"});
  EXPECT_THAT(both.out, AllOf(HasSubstr("2 of 4 runs were already there"), HasSubstr("claims: 1 of 1 hold")));
  EXPECT_EQ(compare({"--out", out(), "--only", "told , slow"}).code, 0);
}

/// One row after the other, other seeds, single runs: the files always have all that was finished.
TEST_F(CliRaces, RowsOfEarlierCallsStay) {
  ASSERT_EQ(compare({"--out", out(), "--only", "slow"}).code, 0);
  const Outcome second = compare({"--out", out(), "--only", "told"});
  ASSERT_EQ(second.code, 0) << second.err;
  EXPECT_THAT(second.out, AllOf(HasSubstr("claims: 1 of 1 hold"),
                                HasSubstr("2 more of this experiment's runs, from earlier calls.\n")));
  EXPECT_EQ(lines(out() + "/runs.csv").size(), 5u);
  EXPECT_EQ(lines(out() + "/table.csv").size(), 3u);
  const Outcome one =
      gripline_with({"run", "experiments/good.json", "--stack", "told", "--seed", "7", "--out", out(), "-j", "2"});
  ASSERT_EQ(one.code, 0) << one.err;
  const std::vector<std::string> runs = lines(out() + "/runs.csv");
  ASSERT_EQ(runs.size(), 6u);
  EXPECT_THAT(runs[1], StartsWith("slow,1,"));
  EXPECT_THAT(runs[5], StartsWith("told,7,"));
  EXPECT_EQ(parse_file(out() + "/claims.json").find("claims")->array().size(), 1u);
  const Outcome more = compare({"--out", out(), "--set", "/seeds/count=3", "--only", "slow"});
  ASSERT_EQ(more.code, 0) << more.err;
  EXPECT_THAT(more.out, HasSubstr("2 of 3 runs were already there."));
  EXPECT_EQ(lines(out() + "/runs.csv").size(), 7u);
}

/// A row computed by another program is not this program's.
TEST_F(CliRaces, AnotherProgramRacesAgain) {
  ASSERT_EQ(compare({"--out", out(), "--only", "slow"}).code, 0);
  const std::string other = folder_ / "bin/gripline";
  fs::create_directories(folder_ / "bin");
  fs::copy_file(gripline_program(), other);
  std::ofstream(other, std::ios::binary | std::ios::app) << "a rebuilt one";
  const Outcome outcome = run_program(
      {other, "compare", "experiments/good.json", "--only", "slow", "--out", out(), "--plugins", plugin_dir()}, Call{});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, Not(HasSubstr("already there")));
}

TEST_F(CliRaces, RunsCanBeContinuedOnlyByOneAtATime) {
  const OutLock lock = open_out_folder(out(), "somebody else's");
  const Outcome outcome = compare({"--out", out()});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(outcome.err, out() + ": another gripline is writing there now; wait for its end or choose another --out\n");
}

/// Same inputs, same bytes: run after run, one at a time or two at a time.
TEST_F(CliRaces, RunsAreTheSameBytesHoweverTheyAreRaced) {
  ASSERT_EQ(compare({"--out", out("a")}).code, 0);
  ASSERT_EQ(compare({"--out", out("b"), "-j", "2"}).code, 0);
  int compared = 0;
  for (const auto& entry : fs::recursive_directory_iterator(out("a"))) {
    const fs::path relative = fs::relative(entry.path(), out("a"));
    const std::string name = relative.filename().string();
    const bool timed =
        name.starts_with("timing.") || name == "runs.csv" || name == "table.csv" || name.ends_with(".html");
    if (entry.is_directory() || timed || name == "claims.json") continue;
    EXPECT_EQ(contents(entry.path()), contents(out("b") / relative)) << relative;
    ++compared;
  }
  EXPECT_GE(compared, 4 * 4);
}

TEST_F(CliRaces, FinishedRunsAreKeptAndForceBeginsAgain) {
  ASSERT_EQ(compare({"--out", out()}).code, 0);
  const std::string before = contents(out() + "/slow/1/timing.csv");
  EXPECT_THAT(compare({"--out", out()}).out, HasSubstr("4 of 4 runs were already there."));
  EXPECT_EQ(contents(out() + "/slow/1/timing.csv"), before);
  const Outcome other = compare({"--out", out(), "--set", "/base/mu_init=0.9"});
  EXPECT_EQ(other.code, 2);
  EXPECT_EQ(other.err, out() +
                           " already holds another experiment (/base/mu_init: 1 -> 0.9); choose another --out, or "
                           "--force to replace it\n");
  const Outcome forced = compare({"--out", out(), "--set", "/base/mu_init=0.9", "--force"});
  EXPECT_EQ(forced.code, 0);
  EXPECT_THAT(forced.out, Not(HasSubstr("already there")));
}

/// Adding a seed, a row or a parameter races what is new, and nothing else.
TEST_F(CliRaces, AnEditedExperimentKeepsWhatItDoesNotTouch) {
  ASSERT_EQ(compare({"--out", out()}).code, 0);
  const std::string before = contents(out() + "/told/1/timing.csv");
  const Outcome row = compare({"--out", out(), "--set", R"(/stacks/third={"planner": {"params": {"mu": 0.4}}})"});
  EXPECT_EQ(row.code, 0) << row.err;
  EXPECT_THAT(row.out, AllOf(HasSubstr("since the last call into "), HasSubstr("/out:\n  /stacks/third: new\n"),
                             HasSubstr("4 of 6 runs were already there.")));
  const Outcome changed = compare({"--out", out(), "--set", R"(/stacks/third={"planner": {"params": {"mu": 0.35}}})",
                                   "--set", R"(/stacks/slow={"planner": {"params": {"mu": 0.25}}})"});
  EXPECT_EQ(changed.code, 0) << changed.err;
  EXPECT_THAT(changed.out, AllOf(HasSubstr("  /stacks/third/planner/params/mu: 0.4 -> 0.35\n"),
                                 HasSubstr("2 of 6 runs were already there."),
                                 HasSubstr("4 finished runs of other inputs or another gripline were raced again.")));
  EXPECT_EQ(contents(out() + "/told/1/timing.csv"), before);
}

/// The header of every table that a race leaves, against `gripline columns`.
TEST_F(CliRaces, EveryColumnIsDocumented) {
  ASSERT_EQ(compare({"--out", out(), "--baseline", "slow", "--set", "/world/laps=1", "--set", "/world/duration=null",
                     "--set", "/world/timeout=20 s", "--set", "/claims=[]"})
                .code,
            0);
  for (const std::string& file : documented_files()) {
    std::set<std::string> documented, found;
    for (const ColumnDoc* column : columns_of(file)) documented.insert(column->name);
    const fs::path here = fs::path(out()) / file, of_a_run = fs::path(out()) / "told/1" / file;
    std::stringstream header(lines(fs::exists(here) ? here : of_a_run).at(0));
    for (std::string name; std::getline(header, name, ',');) found.insert(documented_name(name));
    EXPECT_EQ(found, documented) << file;
  }
  EXPECT_THAT(gripline_with({"columns", "timing.csv"}).out, HasSubstr("  solve_ms"));
  EXPECT_THAT(gripline_with({"columns", "tabel.csv"}).err, HasSubstr("did you mean \"table.csv\"?"));
}

/// Differences of an earlier call are not shown beside the tables of this one.
TEST_F(CliRaces, PairsAreThoseOfTheLastCall) {
  ASSERT_EQ(compare({"--out", out(), "--baseline", "slow"}).code, 0);
  EXPECT_TRUE(fs::exists(out() + "/pairs.csv"));
  ASSERT_EQ(compare({"--out", out()}).code, 0);
  EXPECT_FALSE(fs::exists(out() + "/pairs.csv"));
}

TEST_F(CliRaces, WithoutOutResultsAreUnderTheExperimentsName) {
  const Call here = {folder_.path(), {}};
  const Outcome outcome = gripline_with({"compare", fixture_dir() / "experiments/good.json"}, here);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(fs::exists(folder_ / "out/good/table.csv"));
}

/// config.json is the whole run: given back, it gives the same bytes.
TEST_F(CliRaces, ConfigJsonReproducesItsRun) {
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
/// What validate warns of is warned of by those that race, too, on stderr alone.
TEST_F(CliRaces, ImplausibleValuesAreWarnedOfBeforeRacing) {
  const std::vector<std::string> high = {"--set", R"(/world/friction=[{"t": 0, "factor": 4}])"};
  const std::string warning = "warning: --set /world/friction/0/factor: the friction factor reaches 4; ";
  const Outcome raced = compare({high[0], high[1], "--only", "slow", "--set", "/seeds/count=1", "--out", out()});
  EXPECT_EQ(raced.code, 0) << raced.err;
  EXPECT_THAT(raced.err, HasSubstr(warning));
  EXPECT_THAT(raced.out, Not(HasSubstr("the friction factor")));
  const Outcome one =
      gripline_with({"run", "experiments/good.json", "--stack", "slow", "--out", out("one"), high[0], high[1]});
  EXPECT_EQ(one.code, 0) << one.err;
  EXPECT_THAT(one.err, HasSubstr(warning));
  EXPECT_THAT(compare({"--only", "slow", "--set", "/seeds/count=1", "--out", out("usual")}).err,
              Not(HasSubstr("warning: ")));
}

TEST_F(CliRaces, SetActsOnTheExpandedExperiment) {
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
  // Objects on the way to a parameter are made, in the base and in a stack, which patches it.
  EXPECT_THAT(column("/base/model/params/lf=0.03", "mu_belief_front"), Each(1.0));
  EXPECT_THAT(column("/stacks/slow/planner/params/mu=0.2", "mu_belief_front"), Each(1.0));
  const Node recorded = parse_file(out() + "/slow/1/config.json");
  EXPECT_EQ(find_pointer(recorded, "/stacks/slow/planner/params/mu")->number(), 0.2);
  // A file name starts at the current folder, and swaps the whole world.
  write_text(folder_ / "worlds/other.json",
             R"({"extends": ")" + fixture_dir().string() + R"(/worlds/short.json", "duration": "0.3 s"})");
  EXPECT_EQ(column("/world=" + (folder_ / "worlds/other.json").string(), "t_s").back(), 0.3);
  const Outcome relative = gripline_with({"run", fixture_dir() / "experiments/good.json", "--stack", "slow", "--out",
                                          "o", "--set", "/world=\"worlds/other.json\"", "--set", "/world/dt=0.01"},
                                         {folder_.path(), {}});
  EXPECT_EQ(relative.code, 0) << relative.err;
  const std::vector<double> t = read_csv(folder_ / "o/slow/1/steps.csv").column("t_s");
  EXPECT_EQ(t.back(), 0.3);
  EXPECT_EQ(t.at(1), 0.01);
}

}  // namespace test_cli_races
}  // namespace gripline
