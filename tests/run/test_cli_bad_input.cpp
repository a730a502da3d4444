// Every kind of bad input at the command line: one message, its place in the file, exit code 2, nothing raced.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "support/paths.hpp"
#include "support/program.hpp"

namespace gripline {
namespace test_cli_bad_input {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using namespace testing_support;
namespace fs = std::filesystem;

const fs::path folder = fixture_dir() / "experiments" / "bad";

std::vector<std::string> fixtures() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// Each fixture names what is wrong with it; beside it stands the message, every byte of it.
class BadInput : public testing::TestWithParam<std::string> {};

TEST_P(BadInput, IsRefusedWithItsMessage) {
  const std::string file = GetParam() + ".json", expected = contents(folder / (GetParam() + ".expected"));
  const Outcome validated = gripline_with({"validate", file}, {folder, {}});
  EXPECT_EQ(validated.code, 2);
  EXPECT_EQ(validated.err, expected + "1 error.\n");
  EXPECT_EQ(validated.out, "");
  const Folder out;
  const Outcome raced = gripline_with({"compare", file, "--out", out / "results"}, {folder, {}});
  EXPECT_EQ(raced.code, 2);
  EXPECT_EQ(raced.err, expected);
  EXPECT_FALSE(fs::exists(out / "results"));
}

INSTANTIATE_TEST_SUITE_P(Fixtures, BadInput, testing::ValuesIn(fixtures()), [](const auto& one) { return one.param; });

TEST(BadInputFolder, EveryMessageHasItsFixture) {
  EXPECT_GT(fixtures().size(), 40u);
  for (const auto& entry : fs::directory_iterator(folder))
    EXPECT_TRUE(fs::exists(fs::path(entry.path()).replace_extension(".json"))) << entry.path();
}

/// Forms that look wrong and are right: a byte order mark, Windows line ends, a last point equal to the first.
TEST(OddInput, Works) {
  const Folder place;
  const std::string good = contents(fixture_dir() / "experiments/good.json");
  std::string windows = "\xef\xbb\xbf";
  for (const char c : good) windows += c == '\n' ? "\r\n" : std::string(1, c);
  for (const char* track : {"last_equals_first.csv", "crlf.csv"}) {
    write_text(place / "experiments/good.json", windows);
    write_text(place / "worlds/short.json", R"({"extends": ")" + fixture_dir().string() +
                                                R"(/worlds/short.json", "track": ")" + fixture_dir().string() +
                                                "/tracks/" + track + "\"}");
    const Outcome outcome = gripline_with({"compare", "experiments/good.json", "--out", track}, {place.path(), {}});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(lines(place / (std::string(track) + "/runs.csv")).size(), 5u);
  }
}

TEST(CommandLine, WrongWordsAreRefusedWithAHint) {
  const auto refused = [](std::vector<std::string> words) {
    const Outcome outcome = gripline_with(std::move(words));
    EXPECT_EQ(outcome.code, 2) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    return outcome.err;
  };
  const std::string good = "experiments/good.json";
  EXPECT_EQ(refused({"comapre", good}), "no command \"comapre\"; did you mean \"compare\"?\n");
  EXPECT_EQ(refused({"compare"}), "which experiment? For example experiments/table1.json\n");
  EXPECT_THAT(refused({"compare", good, good}), HasSubstr("one experiment at a time"));
  EXPECT_EQ(refused({"compare", good, "--set", "/world/laps", "1"}),
            "--set /world/laps: expected /json/pointer=VALUE, as one word\n");
  EXPECT_EQ(refused({"compare", good, "-j", "0"}), "-j 0: expected 1 to 4096\n");
  EXPECT_EQ(refused({"compare", good, "-j", "-3"}), "-j -3: expected 1 to 4096\n");
  EXPECT_EQ(refused({"compare", good, "-j", "two"}), "-j two: expected a whole number\n");
  for (const auto& [option, value] : {std::pair("-j", "2"), {"--timeout", "9 s"}, {"--memory", "500"}})
    EXPECT_EQ(
        refused({"compare", good, "--set", "/kind=force_validation", "--set", "/claims=null", "--set", "/seeds/count=1",
                 option, value}),
        option + std::string(" is for the runs of a race, each a process of its own; this experiment is not a race\n"));
  EXPECT_THAT(refused({"compare", good, "--jbos", "2"}),
              AllOf(HasSubstr("--jbos"), HasSubstr("see gripline compare --help")));
  EXPECT_THAT(refused({"compare", good, "--onyl", "told"}),
              HasSubstr("--onyl'; did you mean \"--only\"?; see gripline compare --help"));
  EXPECT_THAT(refused({"report", "out", "--figure"}), HasSubstr("did you mean \"--figures\"?"));
  EXPECT_EQ(refused({"compare", good, "--seeds", "1..5"}),
            "--seeds is of sweep only; here --set /seeds/count=5 (and --set /seeds/first=1)\n");
  EXPECT_THAT(refused({"compare", good, "--set", R"(/world/friction={"shift_per_seed": "3 s"})", "--seeds-from", "a"}),
              AllOf(HasSubstr("--seeds-from \"a\" draws seed "), HasSubstr("--set /seeds/first=")));
  EXPECT_THAT(refused({"sweep", good, "--set", "/seeds/first=1,50"}), HasSubstr("use --seeds 1..50"));
  EXPECT_THAT(refused({"compare", good, "--only", "tolled"}),
              HasSubstr("no stack \"tolled\" in good; did you mean \"told\"?"));
  EXPECT_THAT(refused({"compare", good, "--only", ""}), HasSubstr("--only"));
  EXPECT_THAT(refused({"compare", good, "--only", ","}), HasSubstr("--only names no stack"));
  EXPECT_THAT(refused({"compare", good, "--only", "slow,,told"}), HasSubstr("a name is missing between commas"));
  EXPECT_THAT(refused({"compare", good, "--only", "slow,"}), HasSubstr("a name is missing between commas"));
  EXPECT_EQ(refused({"compare", good, "--out", ""}), "--out names no folder\n");
  EXPECT_EQ(refused({"compare", good, "--plugins", "worlds/short.json"}),
            "--plugins worlds/short.json: is a file, expected a folder of plugins\n");
  EXPECT_EQ(refused({"compare", "worlds/short.json"}), "worlds/short.json: is a world, expected an experiment\n");
  EXPECT_EQ(refused({"compare", "tracks/oval.csv"}), "tracks/oval.csv: is a table, expected an experiment\n");
  EXPECT_EQ(refused({"bench", good}), "bench takes no file: \"" + good + "\"; a world is given by --world\n");
  EXPECT_EQ(refused({"bench", "--world", "worlds/short.json", "--out", "experiments/good.json/b.csv"}),
            "--out experiments/good.json/b.csv: cannot be written: Not a directory\n");
  EXPECT_EQ(refused({"bench", "--instances", "many"}), "--instances many: expected a whole number\n");
  EXPECT_THAT(refused({"compare", good, "--plugins", "no/folder"}), HasSubstr("--plugins no/folder: no such folder"));
  EXPECT_THAT(refused({"compare", good, "--set", "world"}), HasSubstr("expected /json/pointer=VALUE"));
  EXPECT_THAT(refused({"compare", good, "--set", "/wolrd/dt=1"}), HasSubstr("did you mean \"world\"?"));
  EXPECT_EQ(refused({"compare", good, "--set", "/stacks/tolld/planner/params/mu=1"}),
            "--set /stacks/tolld/planner/params/mu: no stack \"tolld\"; did you mean \"told\"?\n");
  EXPECT_THAT(refused({"compare", good, "--set", "/world/plant/plugin/x=1"}),
              HasSubstr("--set /world/plant/plugin/x: /world/plant/plugin is \"dynamic\", it has no members"));
  for (const char* command : {"compare", "run"})
    EXPECT_EQ(
        refused({command, good, "--set", "/kind=rase"}),
        "--set /kind: expected \"race\", \"offline_validation\", \"force_validation\", \"diagnose\" or \"measured\", "
        "found \"rase\"\n");
  // An error that an assignment makes is told at it, also when it shows elsewhere.
  EXPECT_EQ(refused({"compare", good, "--set", "/base/mu_init=0.9", "--set", "/world/duration=null"}),
            "--set /world/duration: a world ends after \"laps\" or after a \"duration\"; neither is given "
            "(worlds/short.json:1:1)\n");
  EXPECT_THAT(refused({"compare", good, "--set", "/base/controller/params={\"horizon\": 0}"}),
              HasSubstr("--set /base/controller/params/horizon: expected a whole number from 2 to 500, found 0"));
  EXPECT_THAT(refused({"compare", "experiments/godo.json"}),
              HasSubstr("experiments/godo.json: no such file; did you mean \"good.json\"?"));
  EXPECT_THAT(refused({"compare", "experiments"}), HasSubstr("experiments: is a folder, expected a file"));
  EXPECT_THAT(refused({"compare", good, "--out", "worlds/short.json"}), HasSubstr("is a file; --out names a folder"));
  EXPECT_THAT(refused({"compare", good, "--out", "worlds", "--force"}), HasSubstr("was not made by gripline"));
  EXPECT_EQ(refused({"run", good}), "which stack? --stack one of: slow, told\n");
  EXPECT_THAT(refused({"run", good, "--stack", "slwo"}),
              HasSubstr("no stack \"slwo\" in good; did you mean \"slow\"?"));
  EXPECT_THAT(refused({"run", good, "--stack", "slow", "--seed", "-1"}),
              HasSubstr("--seed -1: expected 0 to 1000000000"));
  EXPECT_THAT(refused({"run", good, "--stack", "slow", "--seed", "1e3"}), HasSubstr("1e3"));
  EXPECT_EQ(refused({"validate"}), "which file?\n");
  EXPECT_THAT(refused({"plugins", "lsit"}), HasSubstr("did you mean \"list\""));
}

TEST(BlackBox, IsRefusedWhereAModelIsNeeded) {
  const Folder out;
  const std::string log = "README.md";  // any file: it is not read
  for (const char* command : {"diagnose", "predict", "fit"}) {
    const Outcome outcome =
        gripline_with({command, "worlds/full_size.json", log, "--out", out / "result"}, {source_dir(), {}});
    EXPECT_EQ(outcome.code, 2) << command;
    EXPECT_THAT(outcome.err,
                AllOf(HasSubstr("worlds/full_size.json:"), HasSubstr(": /plant: \"double_track\" is a black "
                                                                     "box; ")));
  }
}

TEST(Validate, TellsEverythingWrongWithEveryFile) {
  const Outcome outcome = gripline_with(
      {"validate", "bad/unknown_key.json", "good.json", "bad/claim_of_an_unknown_row.json", "../worlds/short.json"},
      {fixture_dir() / "experiments", {}});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(outcome.out, "good.json: good\n../worlds/short.json: good\n");
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("bad/unknown_key.json:3:3: /stakcs"), HasSubstr("no stack \"tolld\""),
                                 HasSubstr("2 errors.\n"), Not(HasSubstr("terminate"))));
}

TEST(Validate, ReadsWorldsTracksAndCars) {
  const fs::path worlds = source_dir() / "worlds";
  const Outcome good =
      gripline_with({"validate", "ethz.json", "ethz_wear.json", "mobil.json", "full_size.json", "tracks/ethz.json",
                     "tracks/hill.json", "cars/orca_1_43.json", fixture_dir() / "tracks/oval.csv"},
                    {worlds, {}});
  EXPECT_EQ(good.code, 0) << good.err;
  EXPECT_EQ(std::count(good.out.begin(), good.out.end(), '\n'), 8);
  const Outcome bad = gripline_with({"validate", "tracks/open.csv", "bad_json/number_is_text.json"});
  EXPECT_EQ(bad.code, 2);
  EXPECT_THAT(bad.err, AllOf(HasSubstr("open.csv"), HasSubstr("is not an experiment (\"stacks\"), world (\"plant\")")));
}

}  // namespace test_cli_bad_input
}  // namespace gripline
