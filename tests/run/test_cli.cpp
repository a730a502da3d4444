// The commands as users call them: help, plugins, validation, reports, output.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "support/comma_locale.hpp"
#include "support/paths.hpp"
#include "support/race_program.hpp"

namespace gripline {
namespace test_cli {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using namespace testing_support;
namespace fs = std::filesystem;

class Cli : public RaceProgram {};

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
  EXPECT_EQ(version.out, "gripline 0.2.0 (plugin ABI 6)\n");
  const Outcome nothing = gripline_with({});
  EXPECT_EQ(nothing.code, 2);
  EXPECT_THAT(nothing.err, HasSubstr("usage: gripline COMMAND"));
}

TEST_F(Cli, PluginsAreListedAndDescribed) {
  const Outcome list = gripline_with({"plugins", "list"});
  EXPECT_EQ(list.code, 0);
  EXPECT_THAT(list.out, AllOf(HasSubstr("vehicle    dynamic"), HasSubstr("estimator  oracle *"),
                              HasSubstr("* is given the ground truth"), Not(HasSubstr("unusable"))));
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

/// A page goes where it is sent: into a device, not into its place.
TEST_F(Cli, AReportNeverTakesThePlaceOfADevice) {
  ASSERT_EQ(compare({"--out", out(), "--only", "slow"}).code, 0);
  const Outcome full = gripline_with({"report", out(), "--page", "/dev/full"});
  EXPECT_EQ(full.code, 4);
  EXPECT_EQ(full.err, "gripline: cannot write /dev/full: No space left on device\n");
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
  const Outcome over = gripline_with({"report", out(), "--page", out() + "/runs.csv"});
  EXPECT_EQ(over.code, 2);
  EXPECT_THAT(over.err, HasSubstr("is an input of this command and would be overwritten"));
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
  EXPECT_THAT(named(R"({"extends": "experiments/shared/limit_stack.json"})"),
              HasSubstr("no such file; did you mean \"experiments/shared/limit_stacks.json\", which is shipped?"));
  write_text(folder_ / "my_race.json", "{}");
  EXPECT_THAT(error({"compare", "my_race"}), HasSubstr("my_race: no such file; did you mean \"my_race.json\"?"));
  write_text(folder_ / "drive.csv", "");
  EXPECT_THAT(error({"diagnose", "worlds/diagnose_rc43.json", "drvie.csv"}),
              HasSubstr("drvie.csv: no such file; did you mean \"drive.csv\"?"));
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
  write_text(folder_ / "friction.json", R"({"points": [{"t": 0, "factor": 100}]})");
  const Outcome friction = gripline_with({"validate", folder_ / "friction.json"});
  EXPECT_THAT(friction.out, HasSubstr("friction.json: good, 1 warning\n"));
  EXPECT_THAT(friction.err, HasSubstr("the friction factor reaches 100; "));
  const Outcome race = gripline_with({"validate", "experiments/good.json"});
  EXPECT_EQ(race.err, "");
  const Outcome unread = gripline_with({"validate", folder_ / "unread.json"});
  EXPECT_EQ(unread.code, 2);
  EXPECT_THAT(unread.err, HasSubstr("has a parameter \"Cm3\"; did you mean \"Cm"));
}

}  // namespace test_cli
}  // namespace gripline
