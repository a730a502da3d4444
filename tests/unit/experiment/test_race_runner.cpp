#include "experiment/race_runner.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <thread>

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>

#include "experiment/single_run.hpp"
#include "support/host_support.hpp"
#include "support/small_disk.hpp"
#include "util/csv.hpp"

namespace gripline {
namespace test_race_runner {

using testing::HasSubstr;
using testing::UnorderedElementsAre;
using namespace testing_support;
namespace fs = std::filesystem;

/// Five stacks of the small world: two that finish and three that do not.
class Runner : public testing::Test {
 protected:
  RaceSpec race_of(const char* patch = "{}") const {
    Node world = small_world();
    inline_world_files(world);
    Node tree = json(
        R"({"base": {"model": {"plugin": "ekinematic"}, "planner": {"plugin": "fixed_speed", "params": {"mu": 0.3}},
      "controller": {"plugin": "pure_pursuit"}}, "stacks": {"good": {}, "fast": {"planner": {"params": {"mu": 0.5}}},
      "crashes": {"controller": {"plugin": "fault.crashes"}}, "throws": {"controller": {"plugin": "fault.throws"}},
      "no_start": {"controller": {"plugin": "fault.throws_at_start"}}}})");
    tree.set("world", world);
    return read_race("race.json", merge(tree, json(patch)), plugins());
  }
  RunnerOutcome run(const RaceSpec& race, const std::vector<RunId>& ids, int jobs = 1) const {
    return run_all(race, ids, {folder_.path(), jobs, false});
  }
  fs::path file(const std::string& name) const { return folder_ / name; }
  Folder folder_;
};

TEST_F(Runner, ARunLeavesItsFiles) {
  const RaceSpec race = race_of();
  const RunnerOutcome outcome = run(race, {{"good", 1}});
  ASSERT_EQ(outcome.runs.size(), 1u);
  EXPECT_EQ(outcome.runs[0].summary.status, Status::finished);
  EXPECT_EQ(outcome.runs[0].summary.steps, 50);
  EXPECT_GT(outcome.runs[0].timing.cpu_s, 0);
  EXPECT_EQ(outcome.kept, 0);
  EXPECT_FALSE(outcome.interrupted);
  std::vector<std::string> files;
  for (const auto& one : fs::directory_iterator(file("good/1"))) files.push_back(one.path().filename().string());
  EXPECT_THAT(files, UnorderedElementsAre("config.json", "steps.csv", "summary.json", "timing.csv", "replay.csv",
                                          "tyres.csv", "line.csv", "log.txt", "timing.sha256"));
  EXPECT_EQ(content_text(parse_file(file("good/1/config.json"))), content_text(race.run_tree("good", 1)));
}

TEST_F(Runner, ARunThatTheDiskRefusedIsCutOff) {
  DiskWithout full("steps.csv");
  const ScopedDisk use(full);
  const RunnerOutcome outcome = run(race_of(), {{"good", 1}});
  ASSERT_EQ(outcome.cut_off.size(), 1u);
  EXPECT_THAT(outcome.runs.at(0).summary.message, HasSubstr("steps.csv: No space left on device"));
}

/// Two seeds drive alike where nothing is drawn, and not where the start is; every stack starts alike.
TEST_F(Runner, PerturbedRunsStartElsewhere) {
  const RunnerOutcome same = run(race_of(), {{"good", 1}, {"good", 2}});
  EXPECT_FALSE(same.runs[0].drive.empty());
  EXPECT_EQ(same.runs[0].drive, same.runs[1].drive);
  EXPECT_FALSE(fs::exists(file("good/1/draw.json")));
  const RunnerOutcome drawn = run(race_of(R"({"perturb": {"position": "20 mm", "speed": "0.05 m/s"}})"),
                                  {{"good", 1}, {"good", 2}, {"fast", 1}});
  EXPECT_NE(drawn.runs[0].drive, drawn.runs[1].drive);
  const auto start = [&](const char* name) { return read_csv(file(name)).column("y_true_m").front(); };
  EXPECT_NE(start("good/1/steps.csv"), start("good/2/steps.csv"));
  EXPECT_EQ(start("good/1/steps.csv"), start("fast/1/steps.csv"));
  EXPECT_DOUBLE_EQ(parse_file(file("good/1/draw.json")).find("across_m")->number(), start("good/1/steps.csv"));
}

/// Where nothing is drawn, two seeds tell of all: the others are neither driven nor lost.
TEST_F(Runner, SeedsOfOneRunAreDrivenTwiceAtMost) {
  const std::vector<RunId> ids = {{"good", 1}, {"good", 2}, {"good", 3}, {"good", 4}, {"fast", 1}};
  const RunnerOutcome outcome = run(race_of(), ids, 2);
  ASSERT_EQ(outcome.runs.size(), 5u);
  EXPECT_TRUE(fs::exists(file("good/2/steps.csv")));
  EXPECT_FALSE(fs::exists(file("good/3/steps.csv")));
  EXPECT_FALSE(outcome.runs[1].driven_as.has_value());
  for (const std::size_t i : {2u, 3u}) {
    const RunResult& spared = outcome.runs[i];
    EXPECT_EQ(spared.driven_as, 1u);
    EXPECT_EQ(spared.summary.seed, i + 1);
    EXPECT_EQ(spared.summary.status, Status::finished);
    EXPECT_EQ(spared.drive, outcome.runs[0].drive);
    EXPECT_EQ(spared.timing.cpu_s, outcome.runs[0].timing.cpu_s);
  }
  const RunnerOutcome again = run(race_of(), ids);
  EXPECT_EQ(again.kept, 5);
  EXPECT_EQ(again.runs[3].driven_as, 1u);
  const RunnerOutcome drawn =
      run(race_of(R"({"perturb": {"speed": "0.05 m/s"}})"), {{"good", 1}, {"good", 2}, {"good", 3}});
  EXPECT_EQ(drawn.replaced, 3);
  EXPECT_TRUE(fs::exists(file("good/3/steps.csv")));
  EXPECT_NE(drawn.runs[0].drive, drawn.runs[2].drive);
}

/// The first two seeds of a later call may be a copy and its equal: what follows is a copy of the run that was driven.
TEST_F(Runner, ACopyOfACopyNamesTheRunThatWasDriven) {
  const RaceSpec race = race_of();
  run(race, {{"good", 1}, {"good", 2}, {"good", 3}});
  const RunnerOutcome later = run(race, {{"good", 3}, {"good", 4}, {"good", 5}, {"good", 6}});
  ASSERT_EQ(later.runs.size(), 4u);
  for (const std::size_t i : {2u, 3u}) {
    EXPECT_EQ(later.runs[i].driven_as, 1u);
    EXPECT_EQ(later.runs[i].summary.status, Status::finished) << later.runs[i].summary.message;
    EXPECT_EQ(later.runs[i].timing.cpu_s, later.runs[0].timing.cpu_s);
  }
}

/// What is kept says whether its times were measured alone, whatever call asks for it.
TEST_F(Runner, RunsRememberWhetherTheyWereAlone) {
  const RaceSpec race = race_of();
  const std::vector<RunId> ids = {{"good", 1}, {"good", 2}, {"good", 3}, {"fast", 1}};
  EXPECT_TRUE(run(race, {{"fast", 1}}, 1).runs[0].timing.alone);
  for (const int jobs : {2, 1}) {
    const RunnerOutcome outcome = run(race, ids, jobs);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_FALSE(outcome.runs[i].timing.alone) << i;
    EXPECT_TRUE(outcome.runs[3].timing.alone);
  }
}

/// Without them the row would state times of zero.
TEST_F(Runner, ARunThatLostItsTimesIsDrivenAgain) {
  const RaceSpec race = race_of();
  const std::vector<RunId> ids = {{"good", 1}, {"good", 2}, {"good", 3}};
  run(race, ids);
  for (const char* name : {"good/1/timing.csv", "good/1/timing.sha256"}) fs::remove(file(name));
  const RunnerOutcome outcome = run(race, ids);
  EXPECT_EQ(outcome.kept, 1);
  EXPECT_THAT(outcome.notes,
              testing::ElementsAre("good, seed 1: timing.csv is missing since it was raced; it is driven again",
                                   HasSubstr("good, seed 3: timing.csv of seed 1 is missing")));
  for (const RunResult& one : outcome.runs) EXPECT_GT(one.timing.cpu_s, 0);
  EXPECT_EQ(outcome.runs[2].driven_as, 1u);
  EXPECT_EQ(run(race, ids).kept, 3);
}

TEST_F(Runner, FinishedRunsAreKept) {
  const RaceSpec race = race_of();
  run(race, {{"good", 1}});
  const auto before = fs::last_write_time(file("good/1/steps.csv"));
  const RunnerOutcome again = run(race, {{"good", 1}, {"good", 2}});
  EXPECT_EQ(again.kept, 1);
  EXPECT_EQ(again.runs.size(), 2u);
  EXPECT_EQ(fs::last_write_time(file("good/1/steps.csv")), before);
  const RunnerOutcome changed = run(race_of(R"({"base": {"mu_init": 0.9}})"), {{"good", 1}});
  EXPECT_EQ(changed.kept, 0);
}

/// A result that somebody cut or edited is found, said and driven again, to the same bytes.
TEST_F(Runner, AChangedResultIsDrivenAgain) {
  const RaceSpec race = race_of();
  run(race, {{"good", 1}, {"fast", 1}});
  const std::string steps = contents(file("good/1/steps.csv")), summary = contents(file("good/1/summary.json"));
  fs::resize_file(file("good/1/steps.csv"), 1000);
  const RunnerOutcome outcome = run(race, {{"good", 1}, {"fast", 1}});
  EXPECT_EQ(outcome.kept, 1);
  EXPECT_THAT(outcome.notes, testing::ElementsAre(
                                 "good, seed 1: steps.csv was changed or cut since it was raced; it is driven again"));
  EXPECT_EQ(contents(file("good/1/steps.csv")), steps);
  std::string edited = summary;
  edited.replace(edited.find("\"violation_s\": 0"), 16, "\"violation_s\": 9");
  write_text(file("good/1/summary.json"), edited);
  EXPECT_EQ(run(race, {{"good", 1}}).kept, 0);
  EXPECT_EQ(contents(file("good/1/summary.json")), summary);
  EXPECT_EQ(run(race, {{"good", 1}}).kept, 1);
}

/// A relative folder stays what it was, wherever a plugin goes; a parent that ignores its children still hears of them.
TEST_F(Runner, IsNotLedAstrayByItsSurroundings) {
  const RaceSpec race = race_of();
  const fs::path before = fs::current_path();
  fs::current_path(folder_.path());
  const auto signals = std::signal(SIGCHLD, SIG_IGN);
  const RunnerOutcome outcome = run_all(race, {{"good", 1}, {"crashes", 1}}, {"relative", 2, false});
  EXPECT_EQ(std::signal(SIGCHLD, signals), SIG_IGN);
  fs::current_path(before);
  ASSERT_EQ(outcome.runs.size(), 2u);
  EXPECT_EQ(outcome.runs[0].summary.status, Status::finished);
  EXPECT_THAT(outcome.runs[1].summary.message, HasSubstr("signal 11"));
  EXPECT_TRUE(fs::exists(file("relative/good/1/summary.json")));
}

/// One solve in ten may fail; more is said, also of a run that finished.
TEST_F(Runner, ManyFailedSolvesAreSaid) {
  const RaceSpec race = race_of(
      R"({"stacks": {"late": {"controller": {"plugin": "fault.unsolved", "params": {"step": 46}}},
                     "early": {"controller": {"plugin": "fault.unsolved", "params": {"step": 10}}}}})");
  const RunnerOutcome outcome = run(race, {{"late", 1}, {"early", 1}});
  EXPECT_EQ(outcome.runs[0].summary.message, "");
  EXPECT_EQ(outcome.runs[1].summary.status, Status::finished);
  EXPECT_EQ(outcome.runs[1].summary.message, "41 of 51 solves failed");
}

TEST_F(Runner, TheUsualTimeoutIsGenerous) {
  EXPECT_EQ(default_timeout(race_of().world), 600 + 60 * 1);
  EXPECT_EQ(default_timeout(race_of(R"({"world": {"laps": 2, "timeout": "100 s"}})").world), 600 + 60 * 100);
}

/// One lost run; the others finish, and every complete row stays.
TEST_F(Runner, AProcessThatCrashesIsOneLostRun) {
  const RunnerOutcome outcome = run(race_of(), {{"good", 1}, {"crashes", 1}, {"fast", 1}});
  ASSERT_EQ(outcome.runs.size(), 3u);
  EXPECT_EQ(outcome.runs[0].summary.status, Status::finished);
  EXPECT_EQ(outcome.runs[2].summary.status, Status::finished);
  const RunSummary& lost = outcome.runs[1].summary;
  EXPECT_EQ(lost.status, Status::error);
  EXPECT_EQ(lost.message,
            "its process was ended by signal 11 (Segmentation fault) at t = 0.200000 s; the plugin called last was "
            "fault.crashes");
  EXPECT_EQ(lost.stack, "crashes");
  EXPECT_EQ(read_csv(file("crashes/1/steps.csv")).rows(), 10u);
  EXPECT_EQ(contents(file("crashes/1/steps.csv")).back(), '\n');
  EXPECT_TRUE(fs::exists(file("crashes/1/config.json")));
}

TEST_F(Runner, PluginErrorsKeepTheirRowsAndTheirWords) {
  const RunnerOutcome outcome = run(race_of(), {{"throws", 1}, {"no_start", 1}});
  EXPECT_EQ(outcome.runs[0].summary.status, Status::plugin_error);
  EXPECT_EQ(outcome.runs[0].summary.message, "fault.throws at t = 0.200000 s: lost the road");
  EXPECT_EQ(outcome.runs[0].summary.steps, 10);
  EXPECT_EQ(read_csv(file("throws/1/steps.csv")).rows(), 10u) << "the decision after the last step has no row";
  EXPECT_EQ(outcome.runs[1].summary.status, Status::plugin_error);
  EXPECT_EQ(outcome.runs[1].summary.message, "fault.throws_at_start: no fuel");
}

/// exit(0) looks like a good end; the race did not come to one.
TEST_F(Runner, APluginThatEndsItsProcessQuietlyIsALostRun) {
  const RaceSpec race = race_of(R"({"stacks": {"exits": {"controller": {"plugin": "fault.exits"}}}})");
  const RunnerOutcome outcome = run(race, {{"exits", 1}});
  ASSERT_EQ(outcome.runs.size(), 1u);
  EXPECT_EQ(outcome.runs[0].summary.status, Status::error);
  EXPECT_EQ(outcome.runs[0].summary.message,
            "its process ended with exit code 0 before the race did at t = 0.200000 s; the plugin called last was "
            "fault.exits");
  EXPECT_EQ(read_csv(file("exits/1/steps.csv")).rows(), 10u);
  EXPECT_FALSE(fs::exists(file("exits/.1.partial")));
}

TEST_F(Runner, APluginTellsHowFarItsPreparationsAre) {
  const RaceSpec race = race_of(R"({"stacks": {"tells": {"controller": {"plugin": "fault.tells_cache"}}}})");
  RunProgress progress;
  run_here(race, {"tells", 1}, "key", folder_.path(), &progress);
  EXPECT_EQ(progress.what.get(), "counting sheep");
  EXPECT_EQ(progress.preparing.load(), 0.25);
  run_here(race, {"good", 1}, "key", folder_.path(), &progress);
  EXPECT_EQ(progress.fraction.load(), 1.0);
}

/// Everything of the race that stands in the folder, in its order, whoever asked for it; nothing of another race.
TEST_F(Runner, ResultsOfEarlierCallsAreFound) {
  run(race_of(), {{"fast", 1}, {"good", 10}, {"good", 2}, {"throws", 1}});
  write_text(file("good/notes/summary.json"), "{}");
  write_text(file("good/007/summary.json"), "{}");
  std::vector<std::string> found;
  for (const RunResult& one : results_in(race_of(), folder_.path()))
    found.push_back(one.summary.stack + " " + std::to_string(one.summary.seed));
  EXPECT_THAT(found, testing::ElementsAre("good 2", "good 10", "fast 1", "throws 1"));
  EXPECT_TRUE(results_in(race_of(R"({"base": {"mu_init": 0.9}})"), folder_.path()).empty());
}

TEST_F(Runner, BrokenRunsAreNotKept) {
  const std::vector<RunId> ids = {{"crashes", 1}, {"throws", 1}};
  run(race_of(), ids);
  EXPECT_EQ(run(race_of(), ids).kept, 0);
}

TEST_F(Runner, ManyAtOnceAreTheSameBytes) {
  const RaceSpec race = race_of(R"({"world": {"sensors": {"sigma": {"x": 0.002, "yaw_rate": 0.05}}}})");
  const std::vector<RunId> ids = {{"good", 1}, {"good", 2}, {"fast", 1}, {"fast", 2}};
  run_all(race, ids, {file("one"), 1, false});
  run_all(race, ids, {file("two"), 2, false});
  for (const RunId& id : ids)
    for (const char* name : {"steps.csv", "summary.json", "replay.csv", "config.json"}) {
      const std::string path = id.stack + "/" + std::to_string(id.seed) + "/" + name;
      EXPECT_EQ(contents(file("one/" + path)), contents(file("two/" + path))) << path;
    }
  EXPECT_NE(contents(file("one/good/1/steps.csv")), contents(file("one/good/2/steps.csv")));
}

/// Ctrl-C: what runs is stopped, what is finished is kept, nothing half remains, and the same call goes on from there.
TEST_F(Runner, AnInterruptStopsCleanlyAndCanBeContinued) {
  const RaceSpec race = race_of(R"({"stacks": {"long": {}}, "world": {"duration": "20000 s"}})");
  const RaceSpec brief = race_of();
  run(brief, {{"good", 1}});
  std::thread interrupter([&] {
    for (int i = 0; i < 4000 && !fs::exists(file("long/.1.partial")); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    kill(getpid(), SIGINT);
  });
  const RunnerOutcome outcome = run(race, {{"good", 1}, {"long", 1}}, 2);
  interrupter.join();
  EXPECT_TRUE(outcome.interrupted);
  EXPECT_TRUE(outcome.runs.empty());  // what stands in good/1 is another experiment's
  EXPECT_FALSE(fs::exists(file("long/1")));
  EXPECT_FALSE(fs::exists(file("long/.1.partial")));
  const RunnerOutcome again = run(brief, {{"good", 1}, {"fast", 1}});
  EXPECT_FALSE(again.interrupted);
  EXPECT_EQ(again.kept, 1);
  EXPECT_EQ(again.runs.size(), 2u);
}

/// Processes that other threads of this process start while runs go on are not ended with them.
TEST_F(Runner, LeavesOtherChildrenAlone) {
  std::atomic<bool> over{false};
  std::vector<pid_t> others;
  std::thread starts([&] {
    for (int i = 0; i < 50 && !over.load(); ++i) {
      const pid_t pid = fork();
      if (pid == 0) {
        alarm(120);  // in case nobody ends it
        while (true) pause();
      }
      if (pid > 0) others.push_back(pid);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  });
  EXPECT_EQ(run(race_of(), {{"good", 1}, {"crashes", 1}}).runs.size(), 2u);
  over.store(true);
  starts.join();
  EXPECT_FALSE(others.empty());
  for (const pid_t pid : others) {
    EXPECT_EQ(waitpid(pid, nullptr, WNOHANG), 0) << "it goes on";
    kill(pid, SIGKILL);
    waitpid(pid, nullptr, 0);
  }
}

/// Every input of a run names it, and nothing else does.
TEST_F(Runner, AKeyNamesTheInputsOfARun) {
  write_text(file("curve.csv"), "x,y\n0,1\n1,2\n");
  const std::string typed = R"({"stacks": {"typed": {"estimator": {"plugin": "spy.typed", "params": {"curve": ")" +
                            file("curve.csv").string() + R"("}}}}})";
  const auto key = [&](const std::string& patch, const RunId& id) {
    FileHashes hashes;
    return run_key(race_of(patch.c_str()), id, hashes);
  };
  const std::string good = key("{}", {"good", 1});
  EXPECT_EQ(good, key("{}", {"good", 1}));
  EXPECT_EQ(good, key(R"({"note": "words", "world": {"note": "more"}, "claims": []})", {"good", 1}));
  EXPECT_EQ(good, key(R"({"claim_share": 0.5})", {"good", 1}));
  EXPECT_EQ(good, key(R"({"stacks": {"other": {}}, "seeds": {"count": 9}})", {"good", 1}));
  EXPECT_NE(good, key("{}", {"good", 2}));
  EXPECT_NE(good, key("{}", {"fast", 1}));
  EXPECT_NE(good, key(R"({"world": {"duration": 2}})", {"good", 1}));
  EXPECT_NE(good, key(R"({"base": {"mu_init": 0.9}})", {"good", 1}));
  const std::string before = key(typed, {"typed", 1});
  EXPECT_EQ(before, key(typed, {"typed", 1}));
  write_text(file("curve.csv"), "x,y\n0,1\n1,3\n");
  EXPECT_NE(before, key(typed, {"typed", 1}));
}

TEST_F(Runner, LeftoversOfALostProcessDoNoHarm) {
  write_text(file("good/.1.partial/steps.csv"), "half a ro");
  EXPECT_EQ(run(race_of(), {{"good", 1}}).runs[0].summary.status, Status::finished);
  EXPECT_FALSE(fs::exists(file("good/.1.partial")));
}

/// Where nothing can be written the call ends with the reason, and no process stays behind.
TEST_F(Runner, NoProcessOutlivesACallThatFails) {
  write_text(file("good"), "a file where a folder belongs");
  const RaceSpec race = race_of(R"({"stacks": {"long": {}}, "world": {"duration": "20000 s"}})");
  EXPECT_THROW(run(race, {{"long", 1}, {"good", 1}}, 2), std::exception);
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

}  // namespace test_race_runner
}  // namespace gripline
