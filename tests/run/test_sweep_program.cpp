// gripline sweep as its users call it, on this machine: what it leaves, that a second call computes nothing, that
// killing any part of it loses nothing, and that other builds are refused.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include "config/json_file.hpp"
#include "support/paths.hpp"
#include "support/program.hpp"
#include "support/sweep_records.hpp"

namespace gripline {
namespace test_sweep_program {

namespace fs = std::filesystem;
using namespace testing_support;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

std::vector<std::string> partial_files(const fs::path& out) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(out))
    if (entry.path().filename().string().find(".partial") != std::string::npos) names.push_back(entry.path());
  return names;
}

class SweepProgram : public testing::Test {
 protected:
  std::vector<std::string> words(const std::string& name, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all = {gripline_program(),
                                    "sweep",
                                    "experiments/good.json",
                                    "--set",
                                    "/base/planner/params/mu=0.3,0.35",
                                    "--set",
                                    "/world/duration=0.4",
                                    "--seeds",
                                    "1..4",
                                    "-j",
                                    "2",
                                    "--out",
                                    out(name)};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Outcome sweep(const std::string& name, const std::vector<std::string>& more = {}) const {
    return run_program(words(name, more));
  }
  std::string out(const std::string& name) const { return folder_ / name; }
  std::string table(const std::string& name) const { return contents(out(name) + "/table.csv"); }
  Folder folder_;
};

TEST_F(SweepProgram, LeavesOneTableStatisticsAndAReport) {
  const Outcome outcome = sweep("out");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("good (race): 2 settings x 2 rows x 4 seeds"), HasSubstr("runs: 16"),
                                 HasSubstr("16 of 16 runs finished"), HasSubstr("results: " + out("out"))));
  const std::vector<std::string> rows = lines(out("out") + "/table.csv");
  ASSERT_EQ(rows.size(), 17u);
  EXPECT_THAT(rows[0], testing::StartsWith("run,experiment,/base/planner/params/mu,stack,seed,status,finished,"));
  EXPECT_THAT(rows[1], testing::StartsWith("0,good,0.3,slow,1,finished,1,"));
  EXPECT_THAT(rows[16], testing::StartsWith("15,good,0.35,told,4,finished,1,"));
  for (const char* file : {"timing.csv", "missing.csv", "factors.csv", "sensitivity.csv", "best.csv", "report.html"})
    EXPECT_TRUE(fs::exists(out("out") + "/" + file)) << file;
  EXPECT_THAT(contents(out("out") + "/report.html"), HasSubstr("What makes the difference"));
  EXPECT_FALSE(fs::exists(out("out") + "/work"));
  EXPECT_THAT(partial_files(out("out")), IsEmpty());

  // Another number of workers, other tasks: the same bytes. And all of it once.
  ASSERT_EQ(sweep("other", {"-j", "1", "--chunk", "5"}).code, 2) << "-j twice is an error";
  const std::string before = table("out");
  const Outcome again = sweep("out");
  EXPECT_EQ(again.code, 0);
  EXPECT_THAT(again.out, HasSubstr("16 of 16 runs were already there."));
  EXPECT_FALSE(fs::exists(out("out") + "/batches/2"));
  EXPECT_EQ(table("out"), before);
  EXPECT_EQ(gripline_with({"sweep", "status", out("out")}).code, 0);
  EXPECT_THAT(gripline_with({"report", out("out")}).out, HasSubstr("report.html"));
}

TEST_F(SweepProgram, ADryRunPrintsCountTimeAndDiskAndKeepsNothing) {
  const Outcome outcome = sweep("out", {"--dry-run"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("runs: 16, 0 of them already there"), HasSubstr("estimated time: "),
                                 HasSubstr("estimated disk: 72 kB")));
  EXPECT_FALSE(fs::exists(out("out")));
}

TEST_F(SweepProgram, ADryRunOfAListSaysHowManyValuesItHas) {
  write_text(folder_ / "list.csv", "/base/planner/params/mu,/world/duration\n0.3,0.4\n0.35,0.4\n0.3,0.5\n0.4,0.4\n");
  const Outcome outcome =
      gripline_with({"sweep", "experiments/good.json", "--list", folder_ / "list.csv", "--dry-run"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("/base/planner/params/mu: 3 values of the list\n  /world/duration: 2 values"));
}

TEST_F(SweepProgram, OfManyExperimentsIsCalledByTheFirst) {
  std::vector<std::string> call{"sweep", "--set", "/world/duration=0.4", "--seeds", "1", "--out", out("many")};
  for (const char* name : {"a", "b", "c", "d"}) {
    write_text(folder_ / (std::string(name) + ".json"),
               R"({"extends": ")" + (fixture_dir() / "experiments/good.json").string() + R"("})");
    call.push_back(folder_ / (std::string(name) + ".json"));
  }
  ASSERT_EQ(gripline_with(call).code, 0);
  EXPECT_THAT(gripline_with({"sweep", "status", out("many")}).out, testing::StartsWith("a and 3 more: "));
}

TEST_F(SweepProgram, KilledAtAnyMomentItGoesOnToTheSameBytes) {
  ASSERT_EQ(sweep("whole").code, 0);
  for (const int number : {SIGKILL, SIGINT}) {
    SCOPED_TRACE(number);
    const std::string name = "killed" + std::to_string(number);
    const Process process(words(name, {"--chunk", "2"}), folder_.path());
    ASSERT_TRUE(wait_for_records(out(name), 3));
    process.signal(number);
    const Outcome outcome = process.wait();
    EXPECT_EQ(outcome.code, number == SIGKILL ? 128 + SIGKILL : 75) << outcome.err;
    EXPECT_LT(records_in(out(name)), 16u);
    EXPECT_EQ(gripline_with({"sweep", "status", out(name)}).code, 75);
    const Outcome resumed = gripline_with({"sweep", "--resume", "--out", out(name), "-j", "2"});
    EXPECT_EQ(resumed.code, 0) << resumed.err;
    EXPECT_EQ(table(name), table("whole"));
    EXPECT_FALSE(fs::exists(out(name) + "/work"));
  }
}

/// Processes that a process is the parent of.
std::vector<pid_t> children_of(pid_t pid) {
  std::vector<pid_t> all;
  std::ifstream in("/proc/" + std::to_string(pid) + "/task/" + std::to_string(pid) + "/children");
  for (pid_t child = 0; in >> child;) all.push_back(child);
  return all;
}

TEST_F(SweepProgram, AWorkerThatDiesIsReplaced) {
  const Process process(words("out", {"--chunk", "8"}), folder_.path());
  ASSERT_TRUE(wait_for_records(out("out"), 2));
  const std::vector<pid_t> workers = children_of(process.pid());
  ASSERT_FALSE(workers.empty());
  kill(workers.front(), SIGKILL);
  const Outcome outcome = process.wait();
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("a worker was ended by signal 9"));
  EXPECT_EQ(lines(out("out") + "/table.csv").size(), 17u);
}

TEST_F(SweepProgram, RunsThatBreakAreInTheTableAndAreRepeatedByResume) {
  const std::vector<std::string> call = {
      "sweep",     "experiments/good.json",
      "--only",    "told",
      "--seeds",   "1,2",
      "--out",     out("out"),
      "--plugins", fixture_plugins("hostile"),
      "--set",     R"(/stacks/told/controller={"plugin": "hostile.controller", "params": {"mode": "segfaults"}})"};
  const Outcome outcome = gripline_with(call);
  EXPECT_EQ(outcome.code, 4) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("0 of 2 runs finished, 2 broke"));
  EXPECT_THAT(lines(out("out") + "/missing.csv").back(), HasSubstr("error,its process was ended by signal 11"));
  EXPECT_THAT(lines(out("out") + "/table.csv").back(), testing::StartsWith("1,good,told,2,error"));
  EXPECT_THAT(gripline_with(call).out, HasSubstr("2 of 2 runs were already there."));
  EXPECT_FALSE(fs::exists(out("out") + "/batches/2"));
  EXPECT_EQ(gripline_with({"sweep", "--resume", "--out", out("out")}).code, 4);
  EXPECT_TRUE(fs::exists(out("out") + "/batches/2"));
  EXPECT_EQ(gripline_with({"sweep", "status", out("out")}).code, 4);
}

/// Two worlds, and what is the same in both: carried out in the order given.
TEST_F(SweepProgram, WhatIsSetBelowAFactorHolds) {
  const std::string world = (fixture_dir() / "worlds/short.json").string();
  write_text(folder_ / "longer.json", R"({"extends": ")" + world + R"(", "duration": "2 s", "start": {"speed": 1.1}})");
  const std::string worlds = "/world=" + world + "," + (folder_ / "longer.json").string();
  const std::vector<std::string> call = {
      "sweep", "experiments/good.json", "--only", "slow", "--seeds", "1", "--out", out("out"), "--set",
      worlds,  "--keep-files"};
  std::vector<std::string> below = call, above = call;
  below.insert(below.end(), {"--set", "/world/duration=0.2"});
  const Outcome outcome = gripline_with(below);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  std::size_t configs = 0;
  for (const auto& entry : fs::recursive_directory_iterator(out("out") + "/files"))
    if (entry.path().filename() == "config.json") {
      ++configs;
      EXPECT_EQ(parse_file(entry.path()).at("world").at("duration").number(), 0.2);
    }
  EXPECT_EQ(configs, 2u);
  above.insert(above.end(), {"--set", "/world=" + world});
  const Outcome refused = gripline_with(above);
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("/world replaces what the factor /world sets before it"));
}

/// The words are those by which a run that was killed or that the disk refused is told.
TEST_F(SweepProgram, RunsOfPluginsThatSpeakOfAKillAreRecorded) {
  for (const std::string mode : {"speaks_of_a_kill", "speaks_of_the_disk"}) {
    const Outcome outcome = gripline_with(
        {"sweep", "experiments/good.json", "--only", "told", "--seeds", "1", "--out", out(mode), "--plugins",
         fixture_plugins("hostile"), "--set",
         R"(/stacks/told/controller={"plugin": "hostile.controller", "params": {"mode": ")" + mode + R"("}})"});
    EXPECT_EQ(outcome.code, 4) << outcome.err;
    EXPECT_THAT(lines(out(mode) + "/missing.csv").back(), HasSubstr(",plugin_error,hostile.controller at t = "));
  }
}

TEST_F(SweepProgram, ARunThatIsKilledIsMissingWithItsReason) {
  const Outcome outcome = gripline_with(
      {"sweep", "experiments/good.json", "--only", "told", "--seeds", "1", "--out", out("out"), "--plugins",
       fixture_plugins("hostile"), "--set",
       R"(/stacks/told/controller={"plugin": "hostile.controller", "params": {"mode": "kills_itself"}})"});
  EXPECT_EQ(outcome.code, 75) << outcome.err;
  EXPECT_THAT(lines(out("out") + "/missing.csv").back(), HasSubstr(",missing,its process was ended by signal 9"));
}

/// A resumed sweep is done in the folder that it was planned in; its scratch starts where it is called.
TEST_F(SweepProgram, AResumedSweepHasItsScratchWhereItIsCalled) {
  ASSERT_EQ(sweep("out", {"--scratch", out("first")}).code, 0);
  EXPECT_TRUE(fs::is_empty(out("first")));
  fs::remove_all(out("out") + "/results");
  fs::create_directories(out("here"));
  const Outcome resumed = gripline_with({"sweep", "--resume", "--out", out("out"), "--scratch", "scratch"},
                                        {.folder = out("here"), .environment = {}});
  EXPECT_EQ(resumed.code, 0) << resumed.err;
  EXPECT_TRUE(fs::is_empty(out("here") + "/scratch")) << "there, and cleared";
  EXPECT_FALSE(fs::exists(fixture_dir() / "scratch"));
}

TEST_F(SweepProgram, CancelEndsASweepThatIsAtWorkHere) {
  const Process process(words("out", {"--chunk", "2"}), folder_.path());
  ASSERT_TRUE(wait_for_records(out("out"), 2));
  const Outcome cancelled = gripline_with({"sweep", "cancel", out("out")});
  EXPECT_EQ(cancelled.code, 0) << cancelled.err;
  EXPECT_THAT(cancelled.out, HasSubstr(" of 16 runs are finished and kept"));
  EXPECT_EQ(process.wait().code, 75);
  EXPECT_FALSE(fs::exists(out("out") + "/work"));
}

/// The process that a batch names may have ended, and another have its number.
TEST_F(SweepProgram, CancelEndsNoProcessThatOnlyHasTheNumber) {
  ASSERT_EQ(sweep("out", {"--only", "slow"}).code, 0);
  const Process stranger({"sleep", "60"}, folder_.path());
  Node submission = parse_file(out("out") + "/batches/1/submission.json");
  submission.set("jobs", Node(Node::Array{Node(std::to_string(stranger.pid()))}));
  write_text(out("out") + "/batches/1/submission.json", to_json_text(submission));
  const std::string lock = out("out") + "/.lock";
  write_text(lock, std::to_string(stranger.pid()) + " 1 elsewhere\n");
  const int held = open(lock.c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_EQ(flock(held, LOCK_EX | LOCK_NB), 0);
  std::thread release([&] {
    std::this_thread::sleep_for(std::chrono::seconds(1));
    close(held);
  });
  EXPECT_EQ(gripline_with({"sweep", "cancel", out("out")}).code, 0);
  release.join();
  EXPECT_EQ(kill(stranger.pid(), 0), 0);
  EXPECT_EQ(waitpid(stranger.pid(), nullptr, WNOHANG), 0) << "it goes on";
  stranger.signal(SIGKILL);
  (void)stranger.wait();
}

TEST_F(SweepProgram, TakesEveryKindOfExperimentAndSeveralFilesAtOnce) {
  write_text(folder_ / "offline.json", R"({"kind": "offline_validation",
    "train": {"world": ")" + (fixture_dir() / "worlds/short.json").string() +
                                           R"(", "laps": 1},
    "test": {"world": ")" + (fixture_dir() / "worlds/short.json").string() +
                                           R"(", "laps": 1},
    "model": {"plugin": "ekinematic"},
    "driver": {"planner": {"plugin": "fixed_speed", "params": {"mu": 0.3}}, "controller": {"plugin": "pure_pursuit"}},
    "estimators": {"elm": {"plugin": "elm"}}})");
  write_text(folder_ / "forces.json", R"({"kind": "force_validation",
    "world": {"extends": ")" + (fixture_dir() / "worlds/short.json").string() +
                                          R"(", "laps": 3, "duration": null, "timeout": "60 s"},
    "base": {"model": {"plugin": "ekinematic"},
      "planner": {"plugin": "fixed_speed", "params": {"mu": 0.3}}, "controller": {"plugin": "pure_pursuit"}},
    "stacks": {"oracle": {"estimator": {"plugin": "oracle"}, "adapt_after": "1 s"}}})");
  const Outcome outcome =
      gripline_with({"sweep", "experiments/good.json", folder_ / "offline.json", folder_ / "forces.json", "--only",
                     "slow,elm,oracle", "--seeds", "1,2", "-j", "2", "--out", out("out")});
  ASSERT_EQ(outcome.code, 0) << outcome.err << contents(out("out") + "/missing.csv");
  const std::vector<std::string> rows = lines(out("out") + "/table.csv");
  ASSERT_EQ(rows.size(), 7u);
  EXPECT_THAT(rows[0], AllOf(HasSubstr("e_vx_r2"), HasSubstr("force_rear_r2")));
  EXPECT_THAT(rows[3], testing::StartsWith("2,offline,elm,1,done,"));
  EXPECT_THAT(rows[5], testing::StartsWith("4,forces,oracle,1,done,"));
  EXPECT_THAT(gripline_with({"sweep", "experiments/absent.json"}).err, HasSubstr("no such file"));
}

/// A diagnosis, and what it costs in the size of the effect: one case, two settings.
TEST_F(SweepProgram, TakesDiagnoses) {
  const std::string cases =
      R"({"drag": {"hidden": {"plant": {"effects": [{"plugin": "aero_drag", "params": {"a": 0.4}}]}},
    "missing": [["aero_drag"]]}})";
  const Outcome outcome =
      gripline_with({"sweep", source_dir() / "experiments/diagnose/hidden_1_43.json", "--set", "/claims=[]", "--set",
                     "/cases=" + cases, "--set", "/cases/drag/hidden/plant/effects/0/params/a=0.3,0.4", "-j", "2",
                     "--out", out("out")});
  ASSERT_EQ(outcome.code, 0) << outcome.err << contents(out("out") + "/missing.csv");
  const std::vector<std::string> rows = lines(out("out") + "/table.csv");
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_THAT(rows[0], AllOf(HasSubstr("/params/a"), HasSubstr("right")));
  EXPECT_THAT(rows[1], HasSubstr(",0.3,drag,1,done,"));
}

/// Nodes may have the same plugins elsewhere, and no others.
TEST_F(SweepProgram, ATaskTakesTheSamePluginsFromAnotherPlaceAndRefusesOtherBuilds) {
  fs::create_directories(out("plugins"));
  fs::copy(fixture_plugins("spies") / "spies.so", out("plugins") + "/spies.so");
  const Outcome here = gripline_with({"sweep", "experiments/good.json", "--only", "slow", "--plugins", out("plugins"),
                                      "--out", out("out"), "-j", "1", "--chunk", "9", "--set",
                                      R"(/base/controller={"plugin": "spy.constant", "params": {"d": 0.3}})"});
  ASSERT_EQ(here.code, 0) << here.err;
  const std::string before = table("out");
  fs::remove_all(out("out") + "/results");
  fs::rename(out("plugins"), out("elsewhere"));
  const auto task = [&] {
    return gripline_with({"sweep", "task", out("out"), "1", "0"},
                         {.folder = folder_.path(), .environment = {{"GRIPLINE_PLUGIN_PATH", out("elsewhere")}}});
  };
  const Outcome done = task();
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(gripline_with({"sweep", "merge", out("out")}).code, 0);
  EXPECT_EQ(table("out"), before);
  fs::remove_all(out("out") + "/results");
  std::ofstream(out("elsewhere") + "/spies.so", std::ios::app) << '\0';
  const Outcome refused = task();
  EXPECT_EQ(refused.code, 3);
  EXPECT_THAT(refused.err, HasSubstr("spies.so is another build than the one that the sweep was planned with"));
  EXPECT_EQ(records_in(out("out")), 0u);
  const Outcome status = gripline_with({"sweep", "status", out("out")});
  EXPECT_EQ(status.code, 75);
  EXPECT_THAT(status.out, HasSubstr("ended with 3: "));
}

TEST_F(SweepProgram, SaysWhatIsWrongWithItsOptions) {
  const auto err = [&](const std::vector<std::string>& more) {
    const Outcome outcome = sweep("out", more);
    EXPECT_EQ(outcome.code, 2) << outcome.err;
    return outcome.err;
  };
  EXPECT_THAT(err({"--engine", "slrum"}), HasSubstr("did you mean \"slurm\"?"));
  EXPECT_THAT(err({"--set", "/world/dt=1..2"}), HasSubstr("add --latin COUNT"));
  EXPECT_THAT(err({"--chunk", "0"}), HasSubstr("--chunk 0: expected 1 to"));
  EXPECT_THAT(err({"--set", "/base/planner/params/v=1,2"}), HasSubstr("--set /base/planner/params/v"));
  EXPECT_THAT(gripline_with({"sweep", "status", folder_.path()}).err, HasSubstr("holds no sweep"));
  EXPECT_THAT(gripline_with({"sweep", "--resume"}).err, HasSubstr("needs --out DIR"));
  EXPECT_THAT(gripline_with({"sweep"}).err, HasSubstr("which experiment?"));
}

}  // namespace test_sweep_program
}  // namespace gripline
