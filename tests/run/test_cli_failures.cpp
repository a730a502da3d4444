// What goes wrong while racing: plugins that cannot be used, processes that die, an interrupt, a full disk.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/mount.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "support/paths.hpp"
#include "support/program.hpp"
#include "util/csv.hpp"

namespace gripline {
namespace test_cli_failures {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using namespace testing_support;
namespace fs = std::filesystem;

class Failures : public testing::Test {
 protected:
  /// The good experiment with fixture plugins and settings.
  Outcome compare(std::vector<std::string> words) const {
    words.insert(words.begin(), {"compare", "experiments/good.json", "--out", out()});
    return gripline_with(words);
  }
  /// A race of `told` alone, straight on for days.
  std::vector<std::string> endless_race() const {
    return {gripline_program(),
            "compare",
            "experiments/good.json",
            "--out",
            out(),
            "--plugins",
            plugins_of("spies"),
            "--only",
            "told",
            "--set",
            R"(/stacks/told={"controller": {"plugin": "spy.constant"}})",
            "--set",
            "/world/duration=1000000 s"};
  }
  /// What a run of `told` that goes on is writing.
  std::string partial_steps() const { return out() + "/told/.1.partial/steps.csv"; }
  /// Until all of these are there, two minutes at most.
  static void wait_for(const std::vector<std::string>& files) {
    const auto begin = std::chrono::steady_clock::now();
    const auto there = [](const std::string& file) { return fs::exists(file); };
    while (!std::all_of(files.begin(), files.end(), there) &&
           std::chrono::steady_clock::now() - begin < std::chrono::seconds(120))
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  std::string out() const { return folder_ / "out"; }
  static std::string plugins_of(const char* name) { return fixture_plugins(name).string(); }
  Folder folder_;
};

TEST_F(Failures, AMissingPluginNamesTheNearestAndEveryFolderSearched) {
  const Outcome outcome = compare({"--set", "/base/controller/plugin=pure_persuit", "--plugins", plugins_of("spies")});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(
      outcome.err,
      AllOf(StartsWith(
                "--set /base/controller/plugin: no controller plugin \"pure_persuit\"; did you mean \"pure_pursuit\"?"),
            HasSubstr("; searched " + plugins_of("spies") + " "), HasSubstr("lib/gripline")));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1);
  EXPECT_FALSE(fs::exists(out()));
}

TEST_F(Failures, ACommandThatFailsRemovesTheEmptyFoldersItMade) {
  fs::create_directory(folder_ / "there");
  for (const char* where : {"new/deep", "there/deep"}) {
    const Outcome outcome =
        gripline_with({"predict", "worlds/short.json", "no.csv", "--out", folder_ / where / "errors.csv"});
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("no.csv")) << outcome.err;
  }
  EXPECT_FALSE(fs::exists(folder_ / "new"));
  EXPECT_TRUE(fs::exists(folder_ / "there"));
  EXPECT_FALSE(fs::exists(folder_ / "there/deep"));
}

TEST_F(Failures, ALibraryThatCannotBeUsedIsToldWithItsReasonWhenItsPluginIsMissed) {
  const Outcome absent =
      compare({"--set", "/base/controller/plugin=needs_absent", "--plugins", plugins_of("needs_absent")});
  EXPECT_EQ(absent.code, 3);
  EXPECT_THAT(
      absent.err,
      HasSubstr("needs_absent.so: libgripline_absent.so: cannot open shared object file: No such file or directory"));
  const Outcome abi = compare({"--set", "/base/controller/plugin=other", "--plugins", plugins_of("other_abi")});
  EXPECT_EQ(abi.code, 3);
  EXPECT_THAT(abi.err, HasSubstr("other_abi.so: built for plugin ABI 7, this gripline has ABI 6; rebuild the plugin"));
  write_text(folder_ / "text/text.so", "not a library\n");
  const Outcome text = compare({"--set", "/base/controller/plugin=other", "--plugins", folder_ / "text"});
  EXPECT_EQ(text.code, 3);
  EXPECT_THAT(text.err, HasSubstr("text.so: is not a shared library"));
  const Outcome none = compare({"--set", "/base/controller/plugin=other", "--plugins", plugins_of("not_a_plugin")});
  EXPECT_EQ(none.code, 3);
  EXPECT_THAT(none.err, HasSubstr("not_a_plugin.so: is not a gripline plugin: it has no symbol gripline_plugins_abi6"));
}

/// A broken library beside the plugins that are used is no obstacle, and is listed.
TEST_F(Failures, ALibraryThatCannotBeUsedDoesNotDisturbTheOthers) {
  EXPECT_EQ(compare({"--plugins", plugins_of("other_abi"), "--plugins", plugins_of("needs_absent")}).code, 0);
  const Outcome list = gripline_with({"plugins", "list", "--plugins", plugins_of("other_abi")});
  EXPECT_EQ(list.code, 0);
  EXPECT_THAT(list.out, HasSubstr("unusable   " + plugins_of("other_abi") + "/other_abi.so: built for plugin ABI 7"));
}

TEST_F(Failures, OneIdOfferedTwiceIsRefused) {
  const Outcome outcome = compare({"--plugins", plugins_of("duplicate")});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err,
              AllOf(StartsWith("effect \"aero_drag\" is offered twice: by "), HasSubstr("duplicate.so and by ")));
}

TEST_F(Failures, ValidateTellsOfAMissingPluginAndGoesOn) {
  write_text(folder_ / "missing.json",
             R"({"extends": ")" + fixture_dir().string() +
                 R"(/experiments/good.json", "base": {"controller": {"plugin": "mpc_ipotp"}}})");
  const Outcome outcome = gripline_with({"validate", (folder_ / "missing.json").string(), "experiments/good.json"});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_EQ(outcome.out, "experiments/good.json: good\n");
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("missing.json:1:"),
                                 HasSubstr(": /base/controller/plugin: no controller plugin \"mpc_ipotp\""),
                                 HasSubstr("1 error.\n")));
}

/// commands.md: validate lists every error, also beside a plugin that is not there.
TEST_F(Failures, ValidateTellsWhatElseIsWrongBesideAMissingPlugin) {
  write_text(folder_ / "wrong.json", R"({"extends": ")" + fixture_dir().string() +
                                         R"(/experiments/good.json", "claims": ["told.lap0_s <= "],
    "base": {"planner": {"plugin": "fixd_speed"}, "controller": {"plugin": "mpc_ipotp"}, "mu_init": -1}})");
  const Outcome outcome = gripline_with({"validate", (folder_ / "wrong.json").string()});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("/base/planner/plugin: no planner plugin \"fixd_speed\""),
                                 HasSubstr("/base/controller/plugin: no controller plugin \"mpc_ipotp\""),
                                 HasSubstr("/base/mu_init: -1 is out of range"),
                                 HasSubstr("a value is missing after \"<=\""), HasSubstr("4 errors.\n")));
}

TEST_F(Failures, APluginThatCrashesItsProcessIsOneLostRun) {
  const Outcome outcome =
      compare({"--plugins", plugins_of("faults"), "-j", "2", "--set", "/seeds/count=1", "--set",
               R"(/stacks/crashes={"controller": {"plugin": "fault.crashes", "params": {"step": 20}}})"});
  EXPECT_EQ(outcome.code, 4);
  EXPECT_THAT(outcome.err,
              HasSubstr("crashes, seed 1: error: its process was ended by signal 11 (Segmentation fault) at t = "
                        "0.400000 s; the plugin called last was fault.crashes\n"));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_THAT(lines(out() + "/runs.csv").at(1), StartsWith("slow,1,finished,"));
  EXPECT_THAT(lines(out() + "/runs.csv").at(2), StartsWith("told,1,finished,"));
  EXPECT_THAT(lines(out() + "/runs.csv").at(3), StartsWith("crashes,1,error,0,"));
  EXPECT_EQ(read_csv(out() + "/crashes/1/steps.csv").rows(), 20u);
}

TEST_F(Failures, PluginsThatThrowOrReturnNaN) {
  const Outcome outcome = compare({"--plugins", plugins_of("faults"), "--set", "/seeds/count=1", "--set",
                                   R"(/stacks/throws={"controller": {"plugin": "fault.throws"}})", "--set",
                                   R"(/stacks/nan={"controller": {"plugin": "fault.nan_command"}})", "--set",
                                   R"(/stacks/start={"controller": {"plugin": "fault.throws_at_start"}})"});
  EXPECT_EQ(outcome.code, 4);
  EXPECT_THAT(outcome.err,
              AllOf(HasSubstr("throws, seed 1: plugin_error: fault.throws at t = 0.200000 s: lost the road\n"),
                    HasSubstr("nan, seed 1: plugin_error: fault.nan_command at t = 0.200000 s: returned a command that "
                              "is not a number\n"),
                    HasSubstr("start, seed 1: plugin_error: fault.throws_at_start: no fuel\n")));
  EXPECT_EQ(read_csv(out() + "/throws/1/steps.csv").rows(), 10u);
  EXPECT_EQ(read_csv(out() + "/nan/1/steps.csv").rows(), 10u);
  EXPECT_THAT(contents(out() + "/runs.csv"), AllOf(HasSubstr("slow,1,finished,"), HasSubstr("start,1,plugin_error,")));
  EXPECT_THAT(outcome.out, HasSubstr("plugin_error"));
}

/// Ctrl-C: a clean stop that says how to go on, and the same experiment does.
TEST_F(Failures, AnInterruptKeepsWhatIsFinishedAndTheSameCommandGoesOn) {
  // `slow` ends after its lap; `told` drives straight on for days.
  std::vector<std::string> words = {"compare",   "experiments/good.json", "--out", out(),
                                    "--plugins", plugins_of("spies")};
  for (const char* set : {"/seeds/count=1", "/world/duration=null", "/world/laps=1", "/world/timeout=1000000",
                          R"(/stacks/told={"controller": {"plugin": "spy.constant", "params": {"d": 0.3}}})"})
    words.insert(words.end(), {"--set", set});
  std::vector<std::string> program = words;
  program.insert(program.begin(), gripline_program());
  const Process process(program, folder_.path());
  wait_for({out() + "/slow/1/summary.json", partial_steps()});
  process.signal(SIGINT);
  const Outcome stopped = process.wait();
  EXPECT_EQ(stopped.code, 4);
  EXPECT_THAT(stopped.err,
              HasSubstr("interrupted: 1 of 2 runs are finished and kept; the same command goes on from here\n"));
  EXPECT_TRUE(fs::exists(out() + "/slow/1/summary.json"));
  EXPECT_FALSE(fs::exists(out() + "/told/.1.partial"));
  EXPECT_FALSE(fs::exists(out() + "/told/1"));
  EXPECT_EQ(content_text(parse_file(out() + "/claims.json")),
            R"({"claims":[],"skipped":[{"text":"told.violation_s <= slow.violation_s","why":"interrupted"}]})");
  words.insert(words.end(), {"--only", "slow"});
  const Outcome again = gripline_with(words);
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("1 of 1 runs were already there."));
}

/// Ctrl-C before the first run ended: there is nothing to show, and nothing is shown.
TEST_F(Failures, AnInterruptBeforeTheFirstResultPrintsNoTable) {
  const Process process(endless_race(), folder_.path());
  wait_for({partial_steps()});
  process.signal(SIGINT);
  const Outcome stopped = process.wait();
  EXPECT_EQ(stopped.code, 4);
  EXPECT_EQ(stopped.out, "");
  EXPECT_THAT(stopped.err, AllOf(StartsWith("told, seed 1 was stopped"),
                                 EndsWith("\ninterrupted: 0 of 2 runs are finished and kept; the same command goes on "
                                          "from here\n")));
}

/// Whoever kills the parent ends its runs: nobody would collect them.
TEST_F(Failures, RunsDieWithTheirParent) {
  const Process process(endless_race(), folder_.path());
  wait_for({partial_steps()});
  process.signal(SIGKILL);
  EXPECT_EQ(process.wait().code, 128 + SIGKILL);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  const auto size = fs::file_size(partial_steps());
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_EQ(fs::file_size(partial_steps()), size);
}

/// A disk that fills up while racing: one message with the system's reason, and the process ends. Where no small disk
/// may be mounted, a limit on the size of files stands for it.
TEST_F(Failures, AFullDiskIsOneMessage) {
  fs::create_directory(out());
  const std::string command =
      gripline_program().string() + " compare experiments/good.json --out " + out() + " --set '/world/duration=30 s'";
  const Outcome limited = run_program({"/bin/sh", "-c", "trap '' XFSZ; ulimit -f 100; exec " + command});
  EXPECT_EQ(limited.code, 4);
  EXPECT_THAT(limited.err, AllOf(HasSubstr(".csv: File too large"), Not(HasSubstr("terminate called"))));
  fs::remove_all(out());
  fs::create_directory(out());
  if (mount("tmpfs", out().c_str(), "tmpfs", 0, "size=96k") != 0) return;
  const Outcome outcome =
      gripline_with({"compare", "experiments/good.json", "--out", out(), "--set", "/world/duration=30 s"});
  umount2(out().c_str(), MNT_DETACH);
  EXPECT_EQ(outcome.code, 4);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("No space left on device"), Not(HasSubstr("terminate called"))));
}

TEST_F(Failures, ATableThatCannotBeWrittenIsOneMessage) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no such device here";
  ASSERT_EQ(compare({}).code, 0);
  fs::remove(out() + "/table.csv");
  fs::create_symlink("/dev/full", out() + "/table.csv");
  const Outcome outcome = compare({});
  EXPECT_EQ(outcome.code, 4);
  EXPECT_EQ(outcome.err, "gripline: cannot write " + out() + "/table.csv: No space left on device\n");
}

TEST_F(Failures, AFolderWithoutTheRightToWriteIsOneMessage) {
  const Outcome outcome = gripline_with({"compare", "experiments/good.json", "--out", "/proc/gripline"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, StartsWith("cannot make /proc/gripline: "));
}

/// Libraries that end, hold up or meddle with the process that opens them cost themselves, and their words do no harm.
TEST_F(Failures, ALibraryThatEndsItsProcessIsNamedAndTheOthersAreListed) {
  std::vector<std::string> words = {"plugins", "list"};
  for (const char* mode : {"exits", "aborts", "segfaults", "throws", "meddles", "prints"})
    words.insert(words.end(), {"--plugins", (fixture_plugins("constructors") / mode).string()});
  const Outcome list = gripline_with(words);
  EXPECT_EQ(list.code, 0) << list.err;
  EXPECT_THAT(list.out,
              AllOf(HasSubstr("exits.so: cannot be opened: the process that tried ended with exit code 0\n"),
                    HasSubstr("aborts.so: cannot be opened: the process that tried was ended by signal 6 (Aborted)\n"),
                    HasSubstr("constructor.meddles"), HasSubstr("does \\x1b[31mnothing\\x1b[0m; its library does"),
                    HasSubstr("controller pure_pursuit"), Not(HasSubstr("\x1b"))));
}

/// predict, diagnose and bench call plugins in the program itself: its end is told, and a quiet one is none.
TEST_F(Failures, APluginThatEndsTheProgramIsNamed) {
  const auto predict = [&](const std::string& effect) {
    write_text(folder_ / "world.json", R"({"extends": ")" + fixture_dir().string() +
                                           R"(/worlds/short.json", "plant": {"effects": [{"plugin": ")" + effect +
                                           R"("}]}})");
    return gripline_with({"predict", (folder_ / "world.json").string(), "no.csv", "--plugins", plugins_of("faults")});
  };
  const Outcome exits = predict("fault.exits_at_start");
  EXPECT_EQ(exits.code, 4);
  EXPECT_EQ(exits.err,
            "gripline: something called exit() before the work was done; the plugin called last was "
            "fault.exits_at_start\n");
  const Outcome crashes = predict("fault.crashes_at_start");
  EXPECT_NE(crashes.code, 0);
#if !defined(__SANITIZE_ADDRESS__)
  EXPECT_EQ(crashes.code, 128 + SIGABRT);
  EXPECT_EQ(crashes.err, "gripline: ended by signal 6 (Aborted); the plugin called last was fault.crashes_at_start\n");
#endif
}

TEST_F(Failures, ARunThatHangsIsEndedByItsTimeout) {
  const Outcome outcome =
      compare({"--plugins", plugins_of("hostile"), "-j", "2", "--set", "/seeds/count=1", "--timeout", "4 s", "--set",
               R"(/stacks/hangs={"controller": {"plugin": "hostile.controller", "params": {"mode": "loops"}}})"});
  EXPECT_EQ(outcome.code, 4);
  EXPECT_THAT(outcome.err,
              HasSubstr("hangs, seed 1: error: it was stopped after 4 s (--timeout) at t = 0.060000 s; the plugin "
                        "called last was hostile.controller\n"));
  EXPECT_THAT(contents(out() + "/runs.csv"), AllOf(HasSubstr("slow,1,finished,"), HasSubstr("hangs,1,error,")));
  for (const char* wrong : {"0", "-1", "soon", "3 m", "nan"}) EXPECT_EQ(compare({"--timeout", wrong}).code, 2) << wrong;
  for (const char* wrong : {"0", "-1", "much", "1e3"}) EXPECT_EQ(compare({"--memory", wrong}).code, 2) << wrong;
}

/// Started without standard streams, a plugin's words end up in no result; started by one who ignores children, the end
/// of runs is heard of.
TEST_F(Failures, WhoeverStartsItRunsAreWhole) {
  const std::string command = "exec " + gripline_program().string() + " compare experiments/good.json --plugins " +
                              plugins_of("hostile") +
                              " --only prints --set /seeds/count=1 --set '/stacks/prints={\"controller\": "
                              "{\"plugin\": \"hostile.controller\", \"params\": {\"mode\": \"prints\"}}}' --out ";
  const Outcome usual = run_program({"/bin/sh", "-c", command + out() + "/usual"});
  EXPECT_EQ(usual.code, 0) << usual.err;
  run_program({"/bin/sh", "-c", command + out() + "/closed <&- >&-"});
  const Outcome ignoring = run_program({"/bin/sh", "-c",
                                        "env --ignore-signal=CHLD sh -c '" + gripline_program().string() +
                                            " compare experiments/good.json --out " + out() + "/ignoring'"});
  EXPECT_EQ(ignoring.code, 0) << ignoring.err;
  for (const char* name : {"steps.csv", "summary.json", "config.json"})
    EXPECT_EQ(contents(out() + "/usual/prints/1/" + name), contents(out() + "/closed/prints/1/" + name)) << name;
  EXPECT_THAT(contents(out() + "/usual/prints/1/log.txt"), HasSubstr("words of a plugin"));
}

/// Results that are there without the report that was promised are no success. The signal is ignored from the start on,
/// since a library may write while it is loaded (MPI, under Debian 13's Ipopt).
TEST_F(Failures, AReportThatDoesNotFitTheDiskIsNoSuccess) {
  const std::string command =
      gripline_program().string() + " compare experiments/good.json --set /seeds/count=1 --out " + out();
  const Outcome limited = run_program({"/bin/bash", "-c", "trap '' XFSZ; ulimit -f 100; exec " + command});
  EXPECT_EQ(limited.code, 4);
  EXPECT_THAT(limited.err, HasSubstr("no report: cannot write " + out() + "/report.html: File too large\n"));
  EXPECT_TRUE(fs::exists(out() + "/slow/1/summary.json"));
  const Outcome report = run_program(
      {"/bin/bash", "-c", "trap '' XFSZ; ulimit -f 100; exec " + gripline_program().string() + " report " + out()});
  EXPECT_EQ(report.code, 4);
  EXPECT_EQ(gripline_with({"report", out()}).code, 0);
}

}  // namespace test_cli_failures
}  // namespace gripline
