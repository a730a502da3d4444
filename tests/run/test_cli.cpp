// The commands as users call them: what they print, write and end with.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "experiment/column_docs.hpp"
#include "experiment/out_folder.hpp"
#include "measured/delimited_table.hpp"
#include "support/comma_locale.hpp"
#include "support/paths.hpp"
#include "support/program.hpp"
#include "util/csv.hpp"

namespace gripline {
namespace test_cli {

using testing::AllOf;
using testing::Each;
using testing::EndsWith;
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
  for (const char* word : {"compare", "run", "validate", "list, describe, make (new) and check plugins",
                           "1 a claim failed, a plugin failed a check, or diagnose could not decide; 2 your input"})
    EXPECT_THAT(help.out, HasSubstr(word));
  EXPECT_EQ(gripline_with({"compare", "--help"}).code, 0);
  EXPECT_THAT(gripline_with({"compare", "--help"}).out,
              AllOf(HasSubstr("--only"), HasSubstr("--set"), HasSubstr("--plugins"), HasSubstr("--out"),
                    HasSubstr("--force"), HasSubstr("-j")));
  EXPECT_THAT(gripline_with({"run", "--help"}).out, AllOf(HasSubstr("--stack"), HasSubstr("--seed")));
  const Outcome version = gripline_with({"--version"});
  EXPECT_EQ(version.code, 0);
  EXPECT_EQ(version.out, "gripline 0.2.0 (plugin ABI 5)\n");
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
  EXPECT_THAT(gripline_with({"plugins", "describe", "elm"}).out,
              HasSubstr("solver [1] = momentum  momentum|pseudo_inverse"));
  EXPECT_THAT(gripline_with({"plugins", "describe", "oracle"}).out, HasSubstr("needs the truth"));
  EXPECT_THAT(gripline_with({"plugins", "describe", "rear_stiff"}).out, HasSubstr("    Bf (1 + k); Br (1 + k)\n"));
  EXPECT_THAT(gripline_with({"plugins", "describe", "dynamic"}).out,
              HasSubstr("    omega' = (Ff lf cos(delta) - Fr lr) / Iz\n"));
  const Outcome missing = gripline_with({"plugins", "describe", "pure_persuit"});
  EXPECT_EQ(missing.code, 3);
  EXPECT_EQ(missing.err, "no plugin \"pure_persuit\"; did you mean \"pure_pursuit\"?\n");
}

TEST_F(Cli, AValidationSaysWhatItIs) {
  const std::string experiment = source_dir() / "experiments/offline_validation.json";
  const Outcome outcome = gripline_with({"compare", experiment, "--out", out()});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const Node scene = parse_file(out() + "/scene.json");
  EXPECT_EQ(scene.find("name")->text(), "offline_validation");
  EXPECT_EQ(scene.find("kind")->text(), "offline_validation");
  EXPECT_THAT(scene.find("note")->text(), HasSubstr("offline_val"));
  EXPECT_THAT(contents(out() + "/report.html"), HasSubstr("<title>offline_validation "));
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

/// Whatever -j the call has that finds them.
TEST_F(Cli, ClaimsOnTimesAreJudgedOnRunsThatWereDrivenAlone) {
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

TEST_F(Cli, AFailedClaimIsExitCodeOne) {
  const Outcome outcome = compare({"--out", out(), "--set", "/claims/0=told.violation_s < -1"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("claims: 0 of 1 hold"),
                                 HasSubstr("FAILS    told.violation_s < -1   (0 against -1, 0 of 1 runs)")));
}

TEST_F(Cli, OnlySomeRowsAndSkippedClaims) {
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
TEST_F(Cli, RowsOfEarlierCallsStay) {
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
TEST_F(Cli, AnotherProgramRacesAgain) {
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

TEST_F(Cli, RunsCanBeContinuedOnlyByOneAtATime) {
  const OutLock lock = open_out_folder(out(), "somebody else's", false);
  const Outcome outcome = compare({"--out", out()});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(outcome.err, out() + ": another gripline is writing there now; wait for its end or choose another --out\n");
}

/// Same inputs, same bytes: run after run, one at a time or two at a time.
TEST_F(Cli, RunsAreTheSameBytesHoweverTheyAreRaced) {
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

/// Adding a seed, a row or a parameter races what is new, and nothing else.
TEST_F(Cli, AnEditedExperimentKeepsWhatItDoesNotTouch) {
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
TEST_F(Cli, EveryColumnIsDocumented) {
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

TEST_F(Cli, WithoutOutResultsAreUnderTheExperimentsName) {
  const Call here = {folder_.path(), {}};
  const Outcome outcome = gripline_with({"compare", fixture_dir() / "experiments/good.json"}, here);
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
  // Objects on the way to a parameter are made, in the base and in a stack, which patches it.
  EXPECT_THAT(column("/base/model/params/lf=0.03", "mu_belief_front"), Each(1.0));
  EXPECT_THAT(column("/stacks/slow/planner/params/mu=0.2", "mu_belief_front"), Each(1.0));
  EXPECT_EQ(find_pointer(parse_file(out() + "/slow/1/config.json"), "/stacks/slow/planner/params/mu")->number(), 0.2);
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

/// predict and diagnose on the log of a race of 12 s; they take worlds that name their parts in files, as races do.
class ModelsAndLogs : public Cli {
 protected:
  void SetUp() override {
    ASSERT_EQ(
        compare({"--out", out(), "--only", "slow", "--set", "/seeds/count=1", "--set", "/world/duration=12 s"}).code,
        0);
  }
  std::string log() const { return out() + "/slow/1/steps.csv"; }
  static constexpr const char* world = "worlds/short.json";
};

TEST_F(ModelsAndLogs, PredictComparesAWorldWithModelsThatKnowNothing) {
  const Outcome predicted = gripline_with({"predict", world, log(), "--horizon", "0.1", "--out", folder_ / "p.csv"});
  EXPECT_EQ(predicted.code, 0) << predicted.err;
  EXPECT_EQ(measured::read_delimited(folder_ / "p.csv").rows(), 4u);  // three that know nothing, and this world
}

/// The world holds commands until the next row: read as linear between rows the car is half a sample early.
TEST_F(ModelsAndLogs, CommandsAreHeldAsTheWorldHoldsThem) {
  ASSERT_EQ(gripline_with({"predict", world, log(), "--horizon", "0.1", "--out", folder_ / "p.csv"}).code, 0);
  write_text(folder_ / "linear.json",
             R"({"time": "t_s", "channels": {"x": "x_m", "y": "y_m", "yaw": "yaw_rad", "vx": "vx_mps", "vy": "vy_mps",
                "yaw_rate": "yaw_rate_radps", "d": "d", "delta": "delta_rad"}})");
  const Outcome linear = gripline_with(
      {"predict", world, log(), "--horizon", "0.1", "--map", folder_ / "linear.json", "--out", folder_ / "linear.csv"});
  EXPECT_EQ(linear.code, 0) << linear.err;
  const auto error_of = [&](const char* file) {
    const auto table = measured::read_delimited(folder_ / file);
    return table.column[static_cast<std::size_t>(table.find("yaw_rate_radps"))].back();
  };
  EXPECT_LT(error_of("p.csv"), 0.7 * error_of("linear.csv"));
}

/// Displacements from a log: mean over the horizons and at the last one, and how many starts they are of.
struct Displacement {
  double mean = 0, last = 0;
  std::size_t starts = 0;
};

/// From the samples that predict wrote, three of each start, and the log (a row every 0.02 s).
Displacement displacement_of(const fs::path& samples_file, const std::string& log, double slowest) {
  const auto samples = measured::read_delimited(samples_file);
  const CsvTable rows = read_csv(log);
  const auto x = rows.column("x_m"), y = rows.column("y_m"), vx = rows.column("vx_mps"), t = rows.column("t_s");
  const auto row_at = [&](double time) { return static_cast<std::size_t>(std::lround((time - t[0]) / 0.02)); };
  const auto of = [&](const char* name, std::size_t i) {
    return samples.column[static_cast<std::size_t>(samples.find(name))][i];
  };
  Displacement found;
  for (std::size_t i = 0; i + 2 < samples.rows(); i += 3) {
    if (vx.at(row_at(of("start_s", i))) < slowest) continue;
    ++found.starts;
    for (std::size_t j = i; j < i + 3; ++j) {
      const std::size_t row = row_at(of("t_s", j));
      const double distance = std::hypot(of("x_m", j) - x.at(row), of("y_m", j) - y.at(row));
      found.mean += distance / 3;
      if (j == i + 2) found.last += distance;
    }
  }
  found.mean /= static_cast<double>(found.starts);
  found.last /= static_cast<double>(found.starts);
  return found;
}

TEST_F(ModelsAndLogs, DisplacementsAreThoseOfTheSamples) {
  const Outcome paths = gripline_with({"predict", world, log(), "--horizon", "0.1,0.2,0.3", "--every", "0.1",
                                       "--slowest", "1.2", "--samples", folder_ / "paths.csv"});
  EXPECT_EQ(paths.code, 0) << paths.err;
  const Displacement found = displacement_of(folder_ / "paths.csv", log(), 1.2);
  ASSERT_GT(found.starts, 20u);
  const std::string table = paths.out.substr(paths.out.find("displacement [m] over 3 horizons up to 0.3 s"));
  std::istringstream line(table.substr(table.find("this world") + 10));
  Displacement shown;
  line >> shown.mean >> shown.last >> shown.starts;
  EXPECT_EQ(shown.starts, found.starts);
  EXPECT_NEAR(shown.mean, found.mean, 0.01 * shown.mean);
  EXPECT_NEAR(shown.last, found.last, 0.01 * shown.last);
}

/// A table without the column of that index.
std::string without_column(const std::string& file, int column) {
  std::string out;
  for (std::string line : lines(file)) {
    for (int comma = 0; comma < column; ++comma)
      out += line.substr(0, line.find(',') + 1), line.erase(0, line.find(',') + 1);
    out += line.substr(line.find(',') + 1) + "\n";
  }
  return out;
}

/// Without a sideways speed there is nothing to compare it with.
TEST_F(ModelsAndLogs, AChannelThatTheLogLacksIsADash) {
  write_text(folder_ / "without_vy.csv", without_column(log(), 5));
  const Outcome dashed = gripline_with({"predict", world, folder_ / "without_vy.csv", "--horizon", "0.1"});
  EXPECT_EQ(dashed.code, 0) << dashed.err;
  EXPECT_THAT(dashed.out, testing::AllOf(HasSubstr("  -   "), testing::Not(HasSubstr("nan"))));
}

/// What stands in the place of a channel is told: errors of it are not errors of a reading.
TEST_F(ModelsAndLogs, AChannelThatIsReplacedIsTold) {
  EXPECT_EQ(gripline_with({"predict", world, log(), "--horizon", "0.1"}).err, "");
  const std::string without_yaw = folder_ / "without_yaw.csv", without_vx = folder_ / "without_vx.csv";
  write_text(without_yaw, without_column(log(), 3));
  write_text(without_vx, without_column(log(), 4));
  const Outcome course = gripline_with({"predict", world, without_yaw, "--horizon", "0.1"});
  EXPECT_EQ(course.code, 0);
  EXPECT_EQ(course.err,
            "warning: " + without_yaw + ": yaw absent: the course over ground is taken; sideslip is not seen\n");
  const Outcome differences = gripline_with({"predict", world, without_vx, "--horizon", "0.1"});
  EXPECT_EQ(differences.code, 0);
  EXPECT_EQ(differences.err,
            "warning: " + without_vx + ": velocity absent: from differences of the place, half a step late\n");
}

/// What import's table says of lost rows and unknown units is told here too; the form of a file is not.
TEST_F(ModelsAndLogs, WhatIsLeftOutOfALogIsTold) {
  const std::string lossy = folder_ / "lossy.csv";
  std::string text = contents(log());
  const std::size_t end = text.find_last_of('\n', text.size() - 2) + 1;
  text += text.substr(end);  // its time stamp once more
  text += "1,2\n";
  write_text(lossy, text);
  const Outcome told = gripline_with({"predict", world, lossy, "--horizon", "0.1"});
  EXPECT_EQ(told.code, 0) << told.err;
  EXPECT_EQ(told.err, "warning: " + lossy + ": 1 rows of another length, left out\nwarning: " + lossy +
                          ": rows 1 repeat a time stamp: they fill the empty cells of the first row of it\n");
}

TEST_F(ModelsAndLogs, PredictNeverWritesOverWhatItReads) {
  const Outcome over = gripline_with({"predict", world, log(), "--out", log()});
  EXPECT_EQ(over.code, 2);
  EXPECT_EQ(over.err, "--out " + log() + ": is what is read; choose another file\n");
}

TEST_F(ModelsAndLogs, AnExperimentIsNoWorld) {
  const Outcome wrong = gripline_with({"predict", "experiments/good.json", log()});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_EQ(wrong.err, "experiments/good.json: is an experiment, expected a world\n");
}

/// Somebody's folder is not a diagnosis' own; a diagnosis' own is.
TEST_F(ModelsAndLogs, DiagnoseWritesIntoFoldersOfItsOwn) {
  write_text(folder_ / "mine/notes.txt", "mine");
  const Outcome refused = gripline_with({"diagnose", world, log(), "--out", folder_ / "mine"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("mine already holds something else"));
  EXPECT_FALSE(fs::exists(folder_ / "mine/diagnosis.json"));
  for (int i = 0; i < 2; ++i) {
    const Outcome diagnosed = gripline_with({"diagnose", world, log(), "--out", folder_ / "d"});
    EXPECT_THAT(diagnosed.code, testing::AnyOf(0, 1)) << diagnosed.err;
    EXPECT_TRUE(fs::exists(folder_ / "d/diagnosis.json"));
  }
}

/// A page goes where it is sent: into a device, not into its place.
TEST_F(Cli, AReportNeverTakesThePlaceOfADevice) {
  ASSERT_EQ(compare({"--out", out(), "--only", "slow"}).code, 0);
  const Outcome full = gripline_with({"report", out(), "--page", "/dev/full"});
  EXPECT_EQ(full.code, 4);
  EXPECT_EQ(full.err, "gripline: cannot write /dev/full: No space left on device\n");
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
  const Outcome over = gripline_with({"report", out(), "--page", out() + "/runs.csv"});
  EXPECT_EQ(over.code, 2);
  EXPECT_THAT(over.err, HasSubstr("is what is read"));
  write_text(out() + "/scene.json", "{\"name\": \"cu");
  const Outcome corrupt = gripline_with({"report", out()});
  EXPECT_EQ(corrupt.code, 2);
  EXPECT_THAT(corrupt.err, StartsWith(out() + "/scene.json:1:"));
  EXPECT_EQ(std::count(corrupt.err.begin(), corrupt.err.end(), '\n'), 1) << corrupt.err;
}

TEST_F(Cli, DecimalCommasOfTheLocaleChangeNothing) {
  const CommaLocale locale;
  if (!locale.is_set() && CommaLocale::may_be_missing()) GTEST_SKIP() << locale.problem();
  ASSERT_TRUE(locale.is_set()) << locale.problem();
  const Outcome plain = compare({"--out", out("a")}, {fixture_dir(), {{"LC_ALL", "C"}}});
  const Outcome commas = compare(
      {"--out", out("b")}, {fixture_dir(), {{"LC_ALL", CommaLocale::name()}, {"LOCPATH", locale.folder().string()}}});
  ASSERT_EQ(plain.code, 0);
  ASSERT_EQ(commas.code, 0) << commas.err;
  EXPECT_EQ(contents(out("a") + "/slow/1/steps.csv"), contents(out("b") + "/slow/1/steps.csv"));
  EXPECT_EQ(contents(out("a") + "/slow/1/config.json"), contents(out("b") + "/slow/1/config.json"));
  EXPECT_THAT(commas.out, Not(testing::ContainsRegex("[0-9],[0-9]")));
}

TEST_F(Cli, LostOutputIsAFailure) {
  const Outcome outcome = run_program({"/bin/sh", "-c", gripline_program().string() + " plugins list > /dev/full"});
  EXPECT_EQ(outcome.code, 4);
  EXPECT_EQ(outcome.err, "gripline: cannot write the output: No space left on device\n");
}

TEST_F(Cli, OutputMayBePipedAway) {
  const Outcome outcome = run_program({"/bin/sh", "-c", gripline_program().string() + " plugins list | true"});
  EXPECT_EQ(outcome.err, "");
}

TEST_F(Cli, TrackReadsRepairsAndWritesARoad) {
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

/// experiments.md: a world that is a file is replaced whole; what is meant is told as it is to be written.
TEST_F(Cli, KeysInPlaceOfAShippedWorldAreToldHowToExtendIt) {
  const Call elsewhere = {folder_.path(), {}};
  const auto error = [&](const std::string& text) {
    write_text(folder_ / "mine.json", text);
    return gripline_with({"validate", "mine.json"}, elsewhere).err;
  };
  EXPECT_THAT(error(R"({"extends": "experiments/first_race.json", "world": {"laps": 1}})"),
              AllOf(HasSubstr("/world: replaces the file \"../worlds/ethz_wear.json\" of "),
                    HasSubstr("experiments/first_race.json; to change keys of it write {\"extends\": "
                              "\"worlds/ethz_wear.json\", \"laps\": 1}\n1 error.\n")));
  EXPECT_EQ(error(R"({"extends": "experiments/first_race.json",
                      "world": {"extends": "worlds/ethz_wear.json", "laps": 1}})"),
            "");
  EXPECT_THAT(error(R"({"extends": "worlds/ethz.json", "car": {"m": 0.05, "Iz": 1e-5}})"),
              HasSubstr("/car: replaces the file \"cars/orca_1_43.json\" of "));
}

/// commands.md: by every command, from any folder.
TEST_F(Cli, ShippedFilesAreFoundFromAnyFolder) {
  const Call elsewhere = {folder_.path(), {}};
  for (const char* file : {"worlds/ethz.json", "ethz", "first_race", "worlds/tracks/street.json",
                           "worlds/cars/full_size.json", "worlds/friction/ethz_drop_times.json"}) {
    const Outcome outcome = gripline_with({"validate", file}, elsewhere);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, std::string(file) + ": good\n");
  }
  const Outcome track =
      gripline_with({"track", "worlds/tracks/street.json", "--car", "worlds/cars/full_size.json"}, elsewhere);
  EXPECT_EQ(track.code, 0) << track.err;
  EXPECT_THAT(track.out, HasSubstr("drives it"));
  // Both read the world before they refuse what else is wrong.
  const Outcome limit = gripline_with({"limit", "worlds/ethz.json", "--patches"}, elsewhere);
  EXPECT_THAT(limit.err, HasSubstr("has no patches"));
  const Outcome fit = gripline_with({"fit", "worlds/av21.json", "no.csv", "--out", "f.json"}, elsewhere);
  EXPECT_THAT(fit.err, HasSubstr("no.csv: no such file"));
}

TEST_F(Cli, AMisspeltShippedFileIsNamed) {
  const Call elsewhere = {folder_.path(), {}};
  const auto error = [&](std::vector<std::string> words) { return gripline_with(std::move(words), elsewhere).err; };
  EXPECT_THAT(error({"validate", "frist_race"}), HasSubstr("frist_race: no such file; did you mean \"first_race\""));
  EXPECT_THAT(error({"compare", "frist_race"}), HasSubstr("did you mean \"first_race\""));
  EXPECT_THAT(error({"limit", "worlds/etzh.json"}), HasSubstr("did you mean \"worlds/ethz.json\""));
  EXPECT_THAT(error({"track", "worlds/tracks/steet.json"}), HasSubstr("did you mean \"worlds/tracks/street.json\""));
  EXPECT_THAT(error({"validate", "quite_another_thing"}), EndsWith("quite_another_thing: no such file\n1 error.\n"));
  const auto named = [&](const char* text) {
    write_text(folder_ / "mine.json", text);
    return error({"validate", "mine.json"});
  };
  EXPECT_EQ(named(R"({"extends": "experiments/frst_race.json"})"),
            "mine.json:1:13: /extends: \"experiments/frst_race.json\": no such file; did you mean "
            "\"experiments/first_race.json\", which is shipped?\n1 error.\n");
  EXPECT_THAT(named(R"({"extends": "first_race"})"),
              HasSubstr("/extends: \"first_race\": no such file; did you mean \"experiments/first_race.json\", which"));
  EXPECT_THAT(named(R"({"extends": "worlds/ethz.json", "track": "worlds/tracks/ethx.json"})"),
              HasSubstr("/track: \"worlds/tracks/ethx.json\": no such file; did you mean \"worlds/tracks/ethz.json\""));
  EXPECT_THAT(error({"compare", "first_race", "--set", "/world/track=\"worlds/tracks/ethx.json\""}),
              HasSubstr("--set /world/track: \"worlds/tracks/ethx.json\": no such file; did you mean "
                        "\"worlds/tracks/ethz.json\", which is shipped?"));
  write_text(folder_ / "my_race.json", "{}");
  EXPECT_THAT(error({"validate", "my_rase.json"}), HasSubstr("did you mean \"my_race.json\"?"));  // one's own first
}

TEST_F(Cli, AReportIsMadeOfResultsOnly) {
  fs::create_directories(folder_ / "drives/first");
  write_text(folder_ / "drives/first/steps.csv", "t_s,x_m,y_m\n0,0,0\n0.02,1,0\n");
  const Outcome outcome = gripline_with({"report", folder_.path()});
  EXPECT_EQ(outcome.code, 2) << outcome.out;
  EXPECT_THAT(outcome.err,
              AllOf(HasSubstr("nothing to report; expected the folder that compare"), HasSubstr("runs.csv")));
  EXPECT_FALSE(fs::exists(folder_ / "report.html"));
}

/// Allowed and hardly meant: a warning, and the file is good.
TEST_F(Cli, ValidateWarnsOfSlipsOfUnits) {
  const std::string world = source_dir() / "worlds/ethz.json", car = source_dir() / "worlds/cars/full_size.json";
  write_text(folder_ / "world.json", R"({"extends": ")" + world + R"(", "plant": {"params": {"Df": 192}}})");
  write_text(folder_ / "car.json", R"({"extends": ")" + car + R"(", "Iz": 2.093})");
  write_text(folder_ / "unread.json", R"({"extends": ")" + car + R"(", "known_params": {"Cm3": 1}})");
  const Outcome warned = gripline_with({"validate", folder_ / "world.json", folder_ / "car.json"});
  EXPECT_EQ(warned.code, 0) << warned.err;
  EXPECT_THAT(warned.out, AllOf(HasSubstr("world.json: good, 1 warning\n"), HasSubstr("car.json: good, 1 warning\n")));
  EXPECT_THAT(warned.err, AllOf(HasSubstr("the front axle's peak lateral force"), HasSubstr("times m lf lr")));
  const Outcome race = gripline_with({"validate", "experiments/good.json"});
  EXPECT_EQ(race.err, "");
  const Outcome unread = gripline_with({"validate", folder_ / "unread.json"});
  EXPECT_EQ(unread.code, 2);
  EXPECT_THAT(unread.err, HasSubstr("has a parameter \"Cm3\"; did you mean \"Cm"));
}

TEST_F(Cli, TrackMakesFoldersAndTakesUnits) {
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
  EXPECT_THAT(over.err, HasSubstr("road.csv: is what is read; choose another file"));
  EXPECT_EQ(contents(folder_ / "new/deep/road.csv"), before);
  // So would those of a road in JSON, which names its points.
  write_text(folder_ / "new/deep/named.json", R"({"centre": "road.csv"})");
  const Outcome named =
      gripline_with({"track", folder_ / "new/deep/named.json", "--scale", "2", "--out", folder_ / "new/deep/road.csv"});
  EXPECT_EQ(named.code, 2);
  EXPECT_THAT(named.err, HasSubstr("road.csv: is what is read; choose another file"));
  EXPECT_EQ(contents(folder_ / "new/deep/road.csv"), before);
}

TEST_F(Cli, TrackNamesTheRadiusThatARoadStates) {
  for (const auto& [road, radius] : {std::pair{"hill", 22.0}, {"street", 14.0}, {"ring", 25.0}}) {
    const Outcome outcome = gripline_with({"track", source_dir() / "worlds/tracks" / (road + std::string(".json"))});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const std::string found = outcome.out.substr(outcome.out.find("sharpest bend     radius ") + 25);
    EXPECT_NEAR(std::stod(found), radius, 0.01 * radius) << road;
  }
}

TEST_F(Cli, TrackWarnsOfKinksThatSmoothingTakesAway) {
  std::string text = "x_m,y_m\n";
  for (int i = 0; i < 200; ++i) {
    const double r = i == 70 ? 100.8 : 100.0;
    text +=
        std::to_string(r * std::cos(0.0314159265 * i)) + "," + std::to_string(r * std::sin(0.0314159265 * i)) + "\n";
  }
  write_text(folder_ / "kink.csv", text);
  const Outcome raw = gripline_with({"track", folder_ / "kink.csv", "--width", "9.5"});
  EXPECT_EQ(raw.code, 0) << raw.err;
  EXPECT_THAT(raw.err, HasSubstr("if they are noise: --smooth METRES"));
  const Outcome smooth = gripline_with({"track", folder_ / "kink.csv", "--width", "9.5", "--smooth", "1"});
  EXPECT_THAT(smooth.err, Not(HasSubstr("kinks")));
}

TEST_F(Cli, TrackReplacesNoPointsThatItDidNotWrite) {
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
TEST_F(Cli, TrackProposesSmoothingOnlyWhereTheLineIsWrong) {
  std::string text = "x_m,y_m\n";
  for (int i = 0; i < 200; ++i) {
    const double r = i == 70 ? 103.0 : 100.0;
    text +=
        std::to_string(r * std::cos(0.0314159265 * i)) + "," + std::to_string(r * std::sin(0.0314159265 * i)) + "\n";
  }
  write_text(folder_ / "noise.csv", text);
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

TEST_F(Cli, TrackSaysWhatIsLeftOutOfWhatItWrites) {
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

TEST_F(Cli, TrackSaysWhatItCannotRead) {
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

}  // namespace test_cli
}  // namespace gripline
