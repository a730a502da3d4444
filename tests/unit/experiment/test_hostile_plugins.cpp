// Plugins that do what no plugin should (fixtures/plugins/hostile.cpp), one race each: the status names the plugin, the
// other stack finishes, and its bytes are those of a race without it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>

#include "experiment/race_runner.hpp"
#include "support/host_support.hpp"
#include "util/child_process.hpp"
#include "util/csv.hpp"

namespace gripline {
namespace test_hostile_plugins {

using testing::AnyOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Matcher;
using testing::StartsWith;
using namespace testing_support;
namespace fs = std::filesystem;

#if defined(__SANITIZE_ADDRESS__)
constexpr bool sanitized = true;  // its allocator has limits of its own, and it has words of its own at the end
#else
constexpr bool sanitized = false;
#endif

/// The small world with a good stack and one that is given as JSON.
RaceSpec race_with(const std::string& hostile) {
  Node world = small_world();
  inline_world_files(world);
  Node tree = json(
      R"({"base": {"model": {"plugin": "ekinematic"}, "planner": {"plugin": "fixed_speed", "params": {"mu": 0.3}},
      "controller": {"plugin": "pure_pursuit"}}, "stacks": {"good": {}}})");
  tree.set("world", world);
  return read_race("race.json", merge(tree, json(R"({"stacks": {"hostile": )" + hostile + "}}")), plugins());
}

constexpr double patience_s = 4, no_hurry_s = 120;  // of those that hang, of those that do not

struct Race {
  RunResult hostile;
  std::vector<std::string> notes;
};

/// Both stacks at once; checks the good one.
Race run(const Folder& folder, const std::string& hostile, double timeout_s = no_hurry_s) {
  const RaceSpec race = race_with(hostile);
  RunnerOptions options{folder / "with", 2, false};
  options.timeout_s = timeout_s;
  options.memory_mb = sanitized ? 0 : 400;
  const RunnerOutcome outcome = run_all(race, {{"good", 1}, {"hostile", 1}}, options);
  const RunnerOutcome alone = run_all(race, {{"good", 1}}, {folder / "alone", 1, false});
  EXPECT_EQ(outcome.runs.size(), 2u);
  EXPECT_EQ(outcome.runs.at(0).summary.status, Status::finished) << outcome.runs.at(0).summary.message;
  for (const char* name : {"steps.csv", "replay.csv", "tyres.csv", "line.csv", "config.json", "summary.json"})
    EXPECT_EQ(contents(folder / "with/good/1" / name), contents(folder / "alone/good/1" / name)) << name;
  EXPECT_TRUE(children_of_this_process().empty());
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
  EXPECT_FALSE(fs::exists(folder / "with/hostile/.1.partial"));
  return {outcome.runs.at(1), outcome.notes};
}

std::string controller(const std::string& mode) {
  return R"({"controller": {"plugin": "hostile.controller", "params": {"mode": ")" + mode + R"("}}})";
}

struct Case {
  const char* mode;
  Status status;
  Matcher<std::string> message;
  double timeout_s = no_hurry_s;
};
void PrintTo(const Case& one, std::ostream* out) { *out << one.mode; }

class Hostile : public testing::TestWithParam<Case> {};

TEST_P(Hostile, CostsItsOwnRunAndIsNamed) {
  const Case& one = GetParam();
  if (sanitized && one.mode == std::string("eats_memory")) GTEST_SKIP() << "this allocator knows no limit";
  const Folder folder;
  const Race race = run(folder, controller(one.mode), one.timeout_s);
  EXPECT_EQ(race.hostile.summary.status, one.status);
  EXPECT_THAT(race.hostile.summary.message, one.message);
  if (one.status != Status::finished) {
    EXPECT_THAT(race.hostile.summary.message, HasSubstr("hostile.controller"));
  }
}

constexpr const char* place = " at t = 0.060000 s; the plugin called last was hostile.controller";
Case by_signal(const char* mode, const std::string& signal) {
  const std::string message = "its process was ended by signal " + signal + place;
  // A sanitizer reports what it finds and leaves with a code of its own.
  return {mode, Status::error, sanitized ? Matcher<std::string>(EndsWith(place)) : Matcher<std::string>(message)};
}
Case by_exit(const char* mode, int code) {
  return {mode, Status::error,
          "its process ended with exit code " + std::to_string(code) + " before the race did" + place};
}
Case by_timeout(const char* mode) {
  return {mode, Status::error, std::string("it was stopped after 4 s (--timeout)") + place, patience_s};
}
Case by_words(const char* mode, const std::string& words) {
  return {mode, Status::plugin_error, StartsWith("hostile.controller at t = 0.060000 s: " + words)};
}
Case finishes(const char* mode) { return {mode, Status::finished, ""}; }

INSTANTIATE_TEST_SUITE_P(
    Controllers, Hostile,
    testing::Values(
        finishes("nothing"), by_words("throws", "lost the road"),
        by_words("throws_number", "threw something that is not a std::exception"),
        by_words("throws_a_megabyte", "xxxxxxxx"), by_signal("segfaults", "11 (Segmentation fault)"),
        by_signal("aborts", "6 (Aborted)"), by_exit("exits", 0), by_exit("exits_at_once", 0), by_exit("exits_badly", 3),
        by_exit("quick_exits", 0), by_signal("overflows_stack", "11 (Segmentation fault)"),
        by_signal("divides_by_zero", "8 (Floating point exception)"),
        by_signal("illegal_instruction", "4 (Illegal instruction)"), by_signal("bus_error", "7 (Bus error)"),
        by_signal("kills_itself", "9 (Killed)"), by_signal("terminates_itself", "15 (Terminated)"),
        by_signal("kills_its_group", "9 (Killed)"), by_timeout("stops"), by_timeout("loops"), by_timeout("sleeps"),
        by_timeout("ignores_signals_and_loops"), by_signal("rings_the_alarm", "14 (Alarm clock)"),
        by_words("eats_memory", "ran out of memory"), by_signal("thread_throws", "6 (Aborted)"),
        by_signal("ends_its_thread", "6 (Aborted)"), by_exit("becomes_another_program", 0),
        finishes("leaves_a_grandchild"), finishes("leaves_a_daemon"), finishes("forks_and_goes_on"),
        Case{"closes_files", Status::error, HasSubstr("Bad file descriptor")},
        Case{"deletes_files", Status::error, HasSubstr("steps.csv was taken away")},
        Case{"limits_files", Status::error, AnyOf(HasSubstr("File too large"), HasSubstr("exit code 4"))},
        finishes("prints"), finishes("leaves_the_folder"), finishes("changes_locale"), finishes("hides_files"),
        finishes("ignores_children"), by_words("rounds_up", "changed how this process rounds numbers"),
        by_signal("frees_twice", "6 (Aborted)"), by_signal("terminates", "6 (Aborted)"),
        by_words("speaks_of_a_kill", "its process was ended by signal 9 (Killed)"),
        by_words("speaks_of_the_disk", "cannot write plan.csv: No space left on device")),
    [](const auto& info) { return std::string(info.param.mode); });

/// Killed from outside is told by the signal, not by a plugin's words; a plugin that kills itself looks alike.
TEST(Hostile, OnlyRunsThatWereKilledAreCutOff) {
  for (const char* mode : {"speaks_of_a_kill", "speaks_of_the_disk", "closes_files", "limits_files", "aborts"}) {
    const Folder folder;
    EXPECT_TRUE(run_all(race_with(controller(mode)), {{"hostile", 1}}, {folder / "out", 1, false}).cut_off.empty())
        << mode;
  }
  const Folder folder;
  const RunnerOutcome killed =
      run_all(race_with(controller("kills_itself")), {{"good", 1}, {"hostile", 1}}, {folder / "out", 1, false});
  ASSERT_EQ(killed.cut_off.size(), 1u);
  EXPECT_EQ(killed.cut_off.front().stack, "hostile");
}

/// What meddles with its process drives the same bytes as one that does nothing.
TEST(Hostile, WhatMeddlesChangesNoResult) {
  const Folder folder;
  const auto steps_of = [&](const char* mode) {
    const RaceSpec race = race_with(controller(mode));
    const fs::path out = folder / mode;
    EXPECT_EQ(run_all(race, {{"hostile", 1}}, {out, 1, false}).runs.at(0).summary.status, Status::finished) << mode;
    return contents(out / "hostile/1/steps.csv");
  };
  const std::string usual = steps_of("nothing");
  for (const char* mode : {"prints", "leaves_the_folder", "changes_locale", "hides_files", "forks_and_goes_on"})
    EXPECT_EQ(steps_of(mode), usual) << mode;
}

class HostileDestructor : public testing::TestWithParam<Case> {};

/// A race that came to its end stays complete, whatever its plugins do when they are destroyed.
TEST_P(HostileDestructor, SpoilsNoCompleteRun) {
  const Folder folder;
  const Race race = run(folder, R"({"controller": {"plugin": "hostile.destructor", "params": {"mode": ")" +
                                    std::string(GetParam().mode) + R"("}}})");
  EXPECT_EQ(race.hostile.summary.status, Status::finished);
  EXPECT_EQ(race.hostile.summary.message, "");
  EXPECT_EQ(read_csv(folder / "with/hostile/1/steps.csv").rows(), 51u);
  const std::string place = " while hostile.destructor was destroyed";
  std::string notes;
  for (const std::string& note : race.notes) notes += note;
  if (sanitized && GetParam().message.Matches("")) return;
  EXPECT_THAT(notes, GetParam().message);
}

Case after(const char* mode, const std::string& end) {
  return {mode, Status::finished,
          sanitized ? Matcher<std::string>(StartsWith("hostile, seed 1 is complete; afterwards "))
                    : Matcher<std::string>("hostile, seed 1 is complete; afterwards its process " + end +
                                           " while hostile.destructor was destroyed")};
}

INSTANTIATE_TEST_SUITE_P(Destructors, HostileDestructor,
                         testing::Values(after("segfaults", "was ended by signal 11 (Segmentation fault)"),
                                         after("aborts", "was ended by signal 6 (Aborted)"),
                                         after("throws", "was ended by signal 6 (Aborted)"),
                                         after("exits_badly", "ended with exit code 3"),
                                         after("loops", "did not end by itself and was ended"),
                                         Case{"exits", Status::finished, ""}),
                         [](const auto& info) { return std::string(info.param.mode); });

/// Values as they should be and derivatives that are none: no solver goes on from there, and it is not its fault.
TEST(Hostile, DerivativesThatAreNoNumbersEndTheRunByName) {
  for (const char* infinite : {"0", "1"}) {
    const Folder folder;
    const std::string params = R"({"plugin": "hostile.rough", "params": {"infinite": )" + std::string(infinite) + "}}";
    const Race effect = run(folder, R"({"controller": {"plugin": "hostile.asks"}, "model": {"plugin": "ekinematic",
        "effects": [{"plugin": "aero_drag"}, )" +
                                        params + "]}}");
    EXPECT_EQ(effect.hostile.summary.status, Status::plugin_error);
    EXPECT_EQ(effect.hostile.summary.message,
              "hostile.rough at t = 0.080000 s: returned a derivative that is not a number");
    const Folder other;
    const Race estimator =
        run(other, R"({"controller": {"plugin": "hostile.asks", "params": {}}, "estimator": )" + params + "}");
    EXPECT_EQ(estimator.hostile.summary.message,
              "hostile.rough at t = 0.080000 s: returned a derivative that is not a number");
  }
}

}  // namespace test_hostile_plugins
}  // namespace gripline
