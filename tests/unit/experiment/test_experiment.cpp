#include "experiment/experiment.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/host_support.hpp"

namespace gripline {
namespace test_experiment {

using testing::AllOf;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using namespace testing_support;

/// A race of two stacks in a folder of its own, with a world file beside it.
class Experiment : public testing::Test {
 protected:
  Experiment() {
    write_text(folder_ / "world.json", to_json_text(world()));
    write_text(folder_ / "race.json", R"({
  "world": "world.json",
  "seeds": {"first": 3, "count": 2},
  "base": {
    "model": {"plugin": "ekinematic"},
    "estimator": {"plugin": "none"},
    "planner": {"plugin": "fixed_speed", "params": {"mu": 0.3}},
    "controller": {"plugin": "pure_pursuit"},
    "mu_init": 1.1
  },
  "stacks": {
    "plain": {"estimator": null},
    "fast": {"planner": {"params": {"mu": 0.5}}}
  },
  "claims": ["fast.lap0_s < plain.lap0_s"]
})");
  }
  static Node world() {
    Node tree = small_world();
    inline_world_files(tree);
    return tree;
  }
  RaceSpec race(std::vector<std::string> assignments = {}) {
    const auto file = folder_ / "race.json";
    return read_race(file, load_experiment(file, assignments), plugins());
  }
  /// A file that extends race.json.
  RaceSpec extended(const std::string& members, std::vector<std::string> assignments = {}) {
    const auto file = folder_ / "mine.json";
    write_text(file, R"({"extends": "race.json", )" + members + "}");
    return read_race(file, load_experiment(file, assignments), plugins());
  }
  std::string why(std::vector<std::string> assignments) {
    return refusal([&] { race(assignments); });
  }
  Folder folder_;
};

TEST_F(Experiment, IsAWorldStacksSeedsAndClaims) {
  const RaceSpec spec = race();
  EXPECT_EQ(spec.name, "race");
  EXPECT_THAT(spec.seeds, ElementsAre(3, 4));
  ASSERT_EQ(spec.stacks.size(), 2u);
  EXPECT_EQ(spec.stacks[0].name, "plain");
  EXPECT_TRUE(spec.stacks[0].estimator.empty());  // null removes what the base has
  EXPECT_EQ(spec.stacks[0].mu_init, 1.1);
  EXPECT_EQ(spec.stacks[1].estimator.id(), "none");
  EXPECT_EQ(spec.stacks[1].planner.id(), "fixed_speed");
  ASSERT_EQ(spec.claims.size(), 1u);
  EXPECT_EQ(spec.claims[0].left.stack, "fast");
  EXPECT_EQ(spec.claim_share, 0.8);
  EXPECT_EQ(spec.world.duration, 1.0);
}

/// experiments.md: another plugin in a part inherits the parameters of the one it replaces; null drops them at once.
TEST_F(Experiment, AnotherPluginInAPartMayDropInheritedParameters) {
  EXPECT_THAT(
      why({R"(/stacks/fast={"planner": {"plugin": "friction_speed"}})"}),
      HasSubstr(
          "--set /stacks/fast/planner: \"friction_speed\" inherits parameters of \"fixed_speed\" that it does not "
          "have (mu); write \"params\": null beside \"plugin\" to drop them"));
  EXPECT_THAT(why({"/base/planner/plugin=friction_speed"}),
              HasSubstr("--set /base/planner: \"friction_speed\" inherits"));
  const RaceSpec spec = race({R"(/stacks/fast={"planner": {"plugin": "friction_speed", "params": null}})"});
  EXPECT_EQ(spec.stacks[1].planner.id(), "friction_speed");
  const RaceSpec apart = race({"/base/planner=null", R"(/stacks/plain/planner={"plugin": "fixed_speed"})",
                               R"(/stacks/fast/planner={"plugin": "friction_speed", "params": {"pace": 0.8}})"});
  EXPECT_EQ(apart.stacks[1].planner.id(), "friction_speed");
}

TEST_F(Experiment, NullsOfAnExtendingFileRemoveWhatAStackHasItself) {
  const std::string text = contents(folder_ / "race.json");
  std::string own = text;
  own.replace(own.find(R"("fast": {)"), 9, R"("fast": {"estimator": {"plugin": "oracle"}, )");
  write_text(folder_ / "race.json", own);
  EXPECT_EQ(extended(R"("seeds": {})").stacks[1].estimator.id(), "oracle");
  EXPECT_TRUE(extended(R"("stacks": {"fast": {"estimator": null}})").stacks[1].estimator.empty());
  const RaceSpec other = extended(R"("stacks": {"fast": {"planner": {"plugin": "friction_speed", "params": null}}})");
  EXPECT_EQ(other.stacks[1].planner.id(), "friction_speed");
}

/// Also where the plugin that follows does not know the key; what a run keeps says nothing of it.
TEST_F(Experiment, ParametersThatAnExtendingFileRemovesAreGone) {
  const RaceSpec spec = extended(R"("base": {"planner": {"plugin": "friction_speed", "params": {"mu": null}}},
                                    "stacks": {"fast": {"planner": {"params": {"mu": null, "pace": 0.8}}}})");
  EXPECT_EQ(spec.stacks[1].planner.id(), "friction_speed");
  const Node tree = spec.run_tree("plain", 3);
  EXPECT_EQ(find_pointer(tree, "/stacks/plain/planner/params/mu"), nullptr);
  const Node kept = parse_text(to_json_text(tree), "config.json");
  const RaceSpec again = read_race("config.json", kept, plugins());
  EXPECT_EQ(content_text(again.run_tree("plain", 3)), content_text(tree));
}

TEST_F(Experiment, AStackThatAnExtendingFileRemovesIsNotThere) {
  const std::string members = R"("claims": [], "stacks": {"plain": null})";
  EXPECT_EQ(extended(members).stacks.size(), 1u);
  EXPECT_THAT(refusal([&] { extended(members, {"/stacks/plain/mu_init=1"}); }), HasSubstr("no stack \"plain\""));
}

TEST_F(Experiment, AStackIsNotCalledLikeAResult) {
  for (const char* name : {"table.csv", "experiment.json", "scene.json", "report.html", "figures", "runs.csv.partial"})
    EXPECT_THAT(why({"/stacks/" + std::string(name) + "={}"}),
                HasSubstr("a stack's name is a folder among the results: \"" + std::string(name) + '"'));
  EXPECT_EQ(race({"/stacks/table={}"}).stacks.size(), 3u);
}

TEST_F(Experiment, SeedsDefaultToOne) { EXPECT_THAT(race({"/seeds=null"}).seeds, ElementsAre(1)); }

TEST_F(Experiment, AssignmentsActOnTheExpandedTree) {
  const RaceSpec spec = race({R"(/world/friction=[{"t": 0, "factor": 0.5}])", "/world/plant/params={}",
                              "/world/plant/params/Df=0.15", "/base/mu_init=0.7", "/world/duration=3 s"});
  EXPECT_EQ(spec.world.friction.points.at(0).factor, 0.5);
  EXPECT_EQ(spec.stacks[1].mu_init, 0.7);
  EXPECT_EQ(spec.world.duration, 3.0);
  EXPECT_EQ(spec.world.vehicle.model.values[6].number, 0.15);
  EXPECT_THAT(why({"/base/mu_innit=1"}), HasSubstr("unknown key \"mu_innit\"; did you mean \"mu_init\"?"));
  EXPECT_THAT(why({"/bsae/mu_init=1"}),
              AllOf(HasSubstr("--set /bsae: unknown key"), HasSubstr("did you mean \"base\"?")));
  EXPECT_THAT(why({"/world/duration=3 m"}),
              HasSubstr("--set /world/duration: \"3 m\" is a length, expected a time [s]"));
  EXPECT_THAT(why({"mu_init"}), HasSubstr("expected /json/pointer=VALUE"));
}

TEST_F(Experiment, AnAssignmentMayNameAFile) {
  write_text(folder_ / "wet.json", R"([{"t": 0, "factor": 0.4}])");
  const RaceSpec spec = race({"/world/friction=" + (folder_ / "wet.json").string()});
  EXPECT_EQ(spec.world.friction.points.at(0).factor, 0.4);
  EXPECT_TRUE(spec.tree.find("world")->find("friction")->is_array());  // the tree says everything
}

/// What config.json holds: one stack, one seed, no claims, everything in its place.
TEST_F(Experiment, TheTreeOfARunIsTheSameExperimentWithOneStack) {
  const RaceSpec spec = race();
  const Node tree = spec.run_tree("fast", 4);
  EXPECT_EQ(tree.find("claims"), nullptr);
  EXPECT_EQ(tree.find("base"), nullptr);
  const RaceSpec again = read_race("config.json", tree, plugins());
  ASSERT_EQ(again.stacks.size(), 1u);
  EXPECT_EQ(again.stacks[0].name, "fast");
  EXPECT_THAT(again.seeds, ElementsAre(4));
  EXPECT_EQ(again.stacks[0].mu_init, 1.1);
  EXPECT_EQ(content_text(again.run_tree("fast", 4)), content_text(tree));
  const RaceSpec none = read_race("config.json", spec.run_tree("plain", 3), plugins());
  EXPECT_TRUE(none.stacks[0].estimator.empty());
}

TEST_F(Experiment, FilesOfARunAreAbsoluteAndListed) {
  write_text(folder_ / "curve.csv", "x,y\n0,1\n1,2\n");
  const RaceSpec spec = race({R"(/stacks/fast/estimator={"plugin": "spy.typed", "params": {"curve": ")" +
                              (folder_ / "curve.csv").string() + R"("}})"});
  const std::vector<std::filesystem::path> files = files_named(spec.run_tree("fast", 3));
  EXPECT_THAT(files, ElementsAre(folder_ / "curve.csv"));
  EXPECT_TRUE(files_named(spec.run_tree("plain", 3)).empty());
}

TEST_F(Experiment, LibrariesOfAStackAreThoseItUses) {
  const RaceSpec spec = race();
  const auto names = [&](const StackSpec& stack) {
    std::set<std::string> found;
    for (const auto& file : libraries_of(spec.world, std::span(&stack, 1))) found.insert(file.filename().string());
    return found;
  };
  EXPECT_THAT(names(spec.stacks[0]), ElementsAre("dynamic.so", "ekinematic.so", "fixed_speed.so", "pure_pursuit.so"));
  EXPECT_THAT(names(spec.stacks[1]),
              ElementsAre("dynamic.so", "ekinematic.so", "fixed_speed.so", "none.so", "pure_pursuit.so"));
}

TEST_F(Experiment, RefusalsSayWhatAndWhere) {
  EXPECT_THAT(why({"/stacks={}"}), HasSubstr("an experiment needs at least one stack"));
  EXPECT_THAT(why({"/stacks=null"}), HasSubstr("/stacks: missing, expected an object"));
  EXPECT_THAT(why({"/world=null"}), HasSubstr("/world: missing"));
  EXPECT_THAT(why({"/stakcs={}"}), HasSubstr("unknown key \"stakcs\"; did you mean \"stacks\"?"));
  EXPECT_THAT(why({"/stacks/.b={}"}), HasSubstr("a stack's name is a folder and a word of claims"));
  EXPECT_THAT(why({"/stacks/..={}"}), HasSubstr("a stack's name is a folder"));
  EXPECT_THAT(why({"/stacks/a~1b={}"}), HasSubstr("a stack's name is a folder"));
  EXPECT_THAT(why({"/seeds/count=0"}), HasSubstr("/seeds/count: expected a whole number from 1 to 100000, found 0"));
  EXPECT_THAT(why({"/seeds=5"}),
              HasSubstr("/seeds: expected {\"first\", \"count\"}, such as {\"first\": 1, \"count\": 5}; found 5"));
  EXPECT_THAT(why({"/seeds=[1, 2]"}), HasSubstr("such as {\"first\": 1, \"count\": 3}; found an array"));
  EXPECT_THAT(why({"/seeds/first=-1"}), HasSubstr("/seeds/first: expected a whole number"));
  EXPECT_THAT(why({"/claims/0=fastt.lap0_s < 8"}), HasSubstr("no stack \"fastt\"; did you mean \"fast\"?"));
  EXPECT_THAT(why({"/claims/0=fast.lap_s < 8"}), HasSubstr("no column \"lap_s\""));
  EXPECT_THAT(why({"/claim_share=1.5"}), HasSubstr("/claim_share: 1.5 is out of range"));
  EXPECT_THAT(why({"/base/controller/params={\"horizon\": 0}"}),
              HasSubstr("/horizon: expected a whole number from 2 to 500"));
}

TEST_F(Experiment, AFilterOfTheStateRefusesLateSensors) {
  const std::string filter = R"("base": {"state_filter": {"sigma": {"x": 0.002}}}, )";
  const auto with = [&](const std::string& sensors) {
    return refusal([&] { extended(filter + R"("world": {"extends": "world.json", "sensors": )" + sensors + "}"); });
  };
  EXPECT_EQ(with(R"({"rate": {"x": "10 Hz"}})"), "nothing");
  EXPECT_THAT(with(R"({"delay": {"x": "40 ms", "vx": "20 ms", "y": 0}})"),
              AllOf(HasSubstr("/base/state_filter: the filter takes readings for those of now, but the world's sensors "
                              "have a delay (x, vx); expected"),
                    EndsWith("[stack plain, stack fast]")));
}

/// One mistake in the base is told once, with the stacks it concerns.
TEST_F(Experiment, AMistakeOfTheBaseIsToldOnceWithItsStacks) {
  const std::string message = why({"/base/mu_init=0"});
  EXPECT_THAT(message, HasSubstr("/base/mu_init: 0 is out of range"));
  EXPECT_THAT(message, EndsWith("[stack plain, stack fast]"));
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 0);
}

TEST_F(Experiment, TwoStacksOfOneNameAreRefused) {
  write_text(folder_ / "race.json", R"({"world": "world.json", "stacks": {
  "elm": {},
  "elm": {}
}})");
  EXPECT_THAT(why({}), HasSubstr("race.json:3:3: /stacks/elm: "));
}

TEST_F(Experiment, KindsAreKnown) {
  EXPECT_EQ(experiment_kind(json("{}")), "race");
  EXPECT_EQ(experiment_kind(json(R"({"kind": "offline_validation"})")), "offline_validation");
}

}  // namespace test_experiment
}  // namespace gripline
