#include "sweep/sweep.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ctime>
#include <fstream>

#include "config/hash.hpp"
#include "config/json_file.hpp"
#include "support/sweep_rig.hpp"

namespace gripline::sweep {
namespace test_sweep {

namespace fs = std::filesystem;
using namespace testing_support;
using testing::HasSubstr;
using testing::Not;

class Planning : public SweepRig {};

TEST_F(Planning, AValueThatIsRefusedIsToldAtItsAssignment) {
  factors({"/base/planner/params/mu=0.3,fast"});
  EXPECT_THAT(refusal([&] { planned(); }), HasSubstr("--set /base/planner/params/mu"));
  factors({"/base/planer/params/mu=0.3,0.4"});
  EXPECT_THAT(refusal([&] { planned(); }), HasSubstr("did you mean \"planner\"?"));
  factors({});
  request_.only = {"slo"};
  EXPECT_THAT(refusal([&] { planned(); }), HasSubstr("no row \"slo\" in the experiments; did you mean \"slow\"?"));
  write_text(out("full") / "thesis.txt", "mine");
  EXPECT_THAT(refusal([&] { require_sweep_folder(out("full")); }),
              HasSubstr("already holds something that is no sweep"));
}

/// Nobody gave the values of a list at --set.
TEST_F(Planning, AValueOfAListThatIsRefusedIsToldInTheList) {
  write_text(folder_ / "list.csv", "/world/duration,/base/planner/params/mu\n0.4,0.3\n0.4, fast\n");
  request_.design = Design::list(folder_ / "list.csv");
  EXPECT_THAT(refusal([&] { planned(); }), HasSubstr("list.csv:3:6: /base/planner/params/mu: fast: "));
  write_text(folder_ / "list.csv", "/base/planner/params/mu,/world/friction\n0.3,{\"points\": x}\n");
  request_.design = Design::list(folder_ / "list.csv");
  EXPECT_THAT(refusal([&] { planned(); }), HasSubstr("list.csv:2:5: /world/friction: {\"points\": x}: "));
}

/// Two of four roads are none: both are told, each with its file, and one that stands in several settings once.
TEST_F(Planning, EveryBadRoadIsToldAtOnce) {
  const std::string good = (fixture_dir() / "tracks/oval.csv").string();
  const auto road = [&](const std::string& name, const char* text) {
    write_text(folder_ / name, text);
    return (folder_ / name).string();
  };
  const std::string open = road("open.json", R"({"half_width": 0.3, "segments": [{"line": 1}]})");
  const std::string narrow =
      road("narrow.json", R"({"half_width": 0.01, "segments": [{"arc": {"radius": 1, "turn": "360 deg"}}]})");
  const auto told_once = [](const std::string& message, const std::string& value) {
    const std::string told = "/world/track: " + value + ": ";
    const std::size_t first = message.find(told);
    return first != std::string::npos && message.find(told, first + 1) == std::string::npos;
  };
  factors({"/world/track=" + open + "," + good + "," + narrow, "/world/duration=0.4,-1"});
  const std::string message = refusal([&] { planned(); });
  EXPECT_TRUE(told_once(message, open) && told_once(message, narrow)) << message;
  EXPECT_THAT(message, testing::AllOf(HasSubstr("/world/duration: -1: "), Not(HasSubstr(good))));
  write_text(folder_ / "roads.csv", "/world/track\n" + good + "\n" + open + "\n" + narrow + "\n" + open + "\n");
  request_.design = Design::list(folder_ / "roads.csv");
  const std::string listed = refusal([&] { planned(); });
  EXPECT_TRUE(told_once(listed, open) && told_once(listed, narrow)) << listed;
  EXPECT_THAT(listed, testing::AllOf(HasSubstr("roads.csv:3:1: "), HasSubstr("roads.csv:4:1: ")));
}

/// Libraries of one name in two folders are a list, and older manifests with one text a name read as well.
TEST_F(Planning, AManifestKeepsSeveralLibrariesOfOneName) {
  planned();
  Node manifest = parse_file(out() / "sweep.json");
  manifest.set("libraries", parse_text(R"({"a.so": "12", "zz.so": ["34", "56"]})"));
  write_text(out() / "sweep.json", to_json_text(manifest));
  EXPECT_EQ(read_manifest(out()).libraries, (Libraries{{"a.so", {"12"}}, {"zz.so", {"34", "56"}}}));
}

/// Keys of another plan beside a manifest would give its runs the numbers of others.
TEST_F(Planning, KeysThatAreNotOfTheManifestAreRefused) {
  factors({"/base/planner/params/mu=0.3,0.4"});
  const Sweep sweep = planned();
  const fs::path file = out() / "keys.txt";
  const std::string keys = contents(file);
  EXPECT_EQ(sweep.keys_sha256, sha256_of_file(file));
  const auto said = [&] {
    return refusal([&] {
      const KeyFile opened(out(), sweep);
      EXPECT_EQ(opened.key(0), keys.substr(0, 64));
    });
  };
  EXPECT_EQ(said(), "nothing");
  write_text(file, keys.substr(65) + keys.substr(0, 65));
  EXPECT_EQ(said(), file.string() + " has other keys than sweep.json was written with; plan the sweep again");
  Table table;
  EXPECT_THAT(refusal([&] { merge_records(out(), sweep, table); }), HasSubstr("plan the sweep again"));
}

/// Of these the number of keys is known.
TEST_F(Planning, AFolderOfAnOlderVersionHasNoHashOfItsKeys) {
  planned();
  Node manifest = parse_file(out() / "sweep.json");
  manifest.erase("keys_sha256");
  write_text(out() / "sweep.json", to_json_text(manifest));
  const Sweep sweep = read_manifest(out());
  EXPECT_EQ(KeyFile(out(), sweep).size(), 2u);
  write_text(out() / "keys.txt", contents(out() / "keys.txt").substr(65));
  EXPECT_THAT(refusal([&] { KeyFile(out(), sweep); }), HasSubstr("plan the sweep again"));
}

/// The keys are written before the manifest.
TEST_F(Planning, AFolderInWhichThePlanWasKilledIsPlannedAgain) {
  planned();
  fs::remove(out() / "sweep.json");
  EXPECT_EQ(refusal([&] { require_sweep_folder(out()); }), "nothing");
  write_text(out() / "keys.txt", "of my house\n");
  EXPECT_THAT(refusal([&] { require_sweep_folder(out()); }), HasSubstr("already holds something that is no sweep"));
}

TEST_F(Planning, AnAssignmentThatUndoesAFactorIsRefused) {
  factors({"/base/planner/params/mu=0.3,0.4"});
  request_.assignments = {"/base/planner/params/mu", R"(/base/planner={"plugin": "fixed_speed"})"};
  EXPECT_THAT(refusal([&] { planned(); }), HasSubstr("/base/planner replaces what the factor"));
}

/// Seeds of the experiment are read as a race reads them.
TEST_F(Planning, TakesTheExperimentsOwnSeeds) {
  request_.assignments = {R"(/seeds={"first": 5, "count": 2})"};
  EXPECT_EQ(planned().parts.front().seeds, (std::vector<std::uint64_t>{5, 6}));
  request_.assignments = {"/seeds=null"};
  EXPECT_EQ(planned("none").parts.front().seeds, std::vector<std::uint64_t>{1});
  request_.assignments = {R"(/seeds={"first": -1})"};
  EXPECT_THAT(refusal([&] { planned("bad"); }), HasSubstr("from 0 to 1000000000"));
}

TEST_F(Planning, SeedsAreNotDrawnWhereFrictionComesLaterWithThem) {
  request_.seeds_from = "2b99b83";
  EXPECT_EQ(planned().parts.front().seeds.size(), 1u);
  factors({R"(/world/friction=null,{"points": [{"t": 0, "factor": 0.9}], "shift_per_seed": "3 s"})"});
  EXPECT_THAT(refusal([&] { planned(); }),
              testing::AllOf(HasSubstr("--set /world/friction"), HasSubstr("--seeds-from \"2b99b83\" draws seed "),
                             HasSubstr("--set /seeds/first=")));
  request_.seeds_from.clear();
  EXPECT_EQ(planned().size(), 4u);
}

/// A manifest that lost any member of it, or is none, is refused by name.
TEST_F(Planning, ADamagedManifestIsRefused) {
  planned();
  const fs::path file = out() / "sweep.json";
  const Node whole = parse_file(file);
  const auto expect_refused = [&](const Node& damaged, const std::string& what) {
    write_text(file, to_json_text(damaged));
    EXPECT_EQ(refusal([&] { read_manifest(out()); }),
              file.string() + " is not as gripline wrote it; plan the sweep again")
        << what;
  };
  expect_refused(Node::empty_object(), "{}");
  expect_refused(Node(Node::Array{}), "[]");
  for (const char* key : {"name", "folder", "experiments", "assignments", "design", "seeds_from", "plugin_dirs",
                          "timeout_s", "memory_mb", "keep_files", "version", "program", "libraries"}) {
    Node damaged = whole;
    damaged.erase(key);
    expect_refused(damaged, key);
  }
  for (const char* key : {"file", "name", "kind", "rows", "seeds"}) {
    Node damaged = whole;
    damaged.find("experiments")->array().front().erase(key);
    expect_refused(damaged, std::string("experiments/0/") + key);
  }
  write_text(file, to_json_text(whole));
  EXPECT_EQ(read_manifest(out()).size(), 2u);
}

std::size_t resident_kb() {
  std::ifstream in("/proc/self/status");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("VmRSS:")) return std::stoul(line.substr(6));
  return 0;
}

/// Ten thousand keys in two seconds (issue), and a plan of a hundred thousand that needs no more memory than one of a
/// thousand. Times of a busy machine are those of others: CPU time is asked.
TEST_F(Planning, IsFastAndNeedsNoMemoryForItsRuns) {
  std::string levels = "/base/planner/params/mu=0.3";
  for (int i = 1; i < 100; ++i) levels += "," + std::to_string(0.3 + 0.001 * i);
  factors({levels, "/world/duration=0.5,1,1.5,2,2.5"});
  request_.seeds = parse_seeds("1..10");
  const Sweep ten_thousand = plan(request_, plugins());
  ASSERT_EQ(ten_thousand.size(), 10'000u);
  fs::create_directories(out("big"));
  const std::clock_t begin = std::clock();
  write_manifest(out("big"), ten_thousand, plugins());
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 2.0);
  const std::size_t before = resident_kb();
  request_.seeds = parse_seeds("1..100");
  const Sweep hundred_thousand = plan(request_, plugins());
  ASSERT_EQ(hundred_thousand.size(), 100'000u);
  write_manifest(out("big"), hundred_thousand, plugins());
  EXPECT_LT(resident_kb(), before + 4096);
}

}  // namespace test_sweep
}  // namespace gripline::sweep
