#include "sweep/keys.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/sweep_rig.hpp"

namespace gripline::sweep {
namespace test_keys {

using namespace testing_support;

/// Besides the rig's experiment: a world in files that name and extend others.
class Keys : public SweepRig {
 protected:
  Keys() {
    const std::string short_world = (fixture_dir() / "worlds/short.json").string();
    write_text(folder_ / "car.json", contents(source_dir() / "worlds/cars/orca_1_43.json"));
    write_text(folder_ / "world.json", R"({"extends": ")" + short_world + R"(", "car": "car.json"})");
    write_text(folder_ / "base.json", R"({"points": [{"t": 0, "factor": 1}, {"t": 0.5, "factor": 0.7}]})");
    write_text(folder_ / "drop.json", R"({"extends": "base.json"})");
  }
  std::string keys_of(const Registry& registry = plugins()) {
    const Sweep sweep = plan(request_, registry);
    write_manifest(out("keys"), sweep, registry);
    return contents(out("keys") / "keys.txt");
  }
  void race(const char* experiment) {
    write_text(folder_ / "other.json", experiment);
    request_.files = {folder_ / "other.json"};
  }
  void edit(const std::string& name, const std::string& what, const std::string& by) {
    std::string text = contents(folder_ / name);
    write_text(folder_ / name, text.replace(text.find(what), what.size(), by));
  }
};
constexpr const char* offline = R"({"kind": "offline_validation", "train": {"world": "world.json"},
  "test": {"world": "world.json"}, "model": {"plugin": "ekinematic"}, "driver": {"planner": {"plugin": "fixed_speed"},
  "controller": {"plugin": "pure_pursuit"}}, "estimators": {"elm": {"plugin": "elm"}}})";
constexpr const char* diagnosis = R"({"kind": "diagnose", "nominal": "world.json", "driver": {
  "model": {"plugin": "ekinematic"}, "planner": {"plugin": "fixed_speed"}, "controller": {"plugin": "pure_pursuit"}},
  "cases": {"drop": {"hidden": {"friction": "drop.json"}}}})";

TEST_F(Keys, KeysDependOnWhatIsRacedAndOnNothingElse) {
  factors({"/base/planner/params/mu=0.3,0.4"});
  planned();
  const std::string keys = contents(out() / "keys.txt");
  EXPECT_EQ(keys.size(), 4u * 65);
  const std::string text = contents(file());
  const auto with = [&](const std::string& what, const std::string& by) {
    std::string changed = text;
    changed.replace(changed.find(what), what.size(), by);
    write_text(file(), changed);
    planned("other");
    return contents(out("other") / "keys.txt");
  };
  EXPECT_EQ(with("\"claims\": [\"slow.violation_s <= 1\"]", "\"note\": \"no claims\""), keys);
  EXPECT_EQ(with("\"claims\": [\"slow.violation_s <= 1\"]", "\"kind\": null, \"perturb\": null"), keys);
  EXPECT_EQ(with("{\"world\"", "{\"seeds\": {\"first\": 1, \"count\": 1}, \"world\""), keys);
  const std::string other = with("\"mu_init\": 0.9", "\"mu_init\": 0.95");  // of the row `fast` alone
  EXPECT_EQ(other.substr(0, 65), keys.substr(0, 65));
  EXPECT_NE(other.substr(65, 65), keys.substr(65, 65));
  EXPECT_NE(with("pure_pursuit", "mpc_sqp"), keys);
  write_text(file(), text);
  request_.assignments = {"/world/duration=0.25"};
  planned("other");
  EXPECT_NE(contents(out("other") / "keys.txt"), keys);
}

/// Every setting is made from the untouched experiment, assignments in the order given.
TEST_F(Keys, AreOfTreesWithWhatIsSetBelowAFactor) {
  const std::string world = (folder_ / "world.json").string();
  write_text(folder_ / "longer.json", R"({"extends": "world.json", "duration": "2 s"})");
  factors({"/world=" + world + "," + (folder_ / "longer.json").string(), "/base/mu_init=null,0.8"});
  request_.assignments = {"/world", "/world/duration=0.25"};
  const Sweep sweep = planned();
  ASSERT_EQ(sweep.design.size(), 4u);
  Trees trees(sweep);
  for (const std::size_t setting : {3, 0, 2, 1, 0}) {
    const Node& tree = trees.setting(0, setting);
    EXPECT_EQ(tree.at("world").at("duration").number(), 0.25) << setting;
    EXPECT_EQ(tree.at("base").at("mu_init").is_null(), setting % 2 == 0) << setting;
  }
  request_.assignments = {"/world/duration=0.25", "/world"};
  const Sweep other = planned("other");
  Trees undone(other);
  EXPECT_EQ(undone.setting(0, 2).at("world").at("duration").text(), "2 s") << "the order given";
}

/// An element is added to every setting once.
TEST_F(Keys, AreOfTreesThatSettingsBeforeLeaveNothingIn) {
  factors({"/base/planner/params/mu=0.3,0.4,0.5"});
  request_.assignments = {"/base/model/effects=[]", "/base/planner/params/mu",
                          R"(/base/model/effects/-={"plugin": "aero_drag"})"};
  const Sweep sweep = planned();
  Trees trees(sweep);
  for (std::size_t setting = 0; setting < 3; ++setting)
    EXPECT_EQ(trees.setting(0, setting).at("base").at("model").at("effects").array().size(), 1u);
}

TEST_F(Keys, DependOnFilesThatFilesName) {
  for (const char* experiment : {offline, diagnosis}) {
    race(experiment);
    const std::string before = keys_of();
    EXPECT_EQ(keys_of(), before);
    edit("car.json", "41 g", "50 g");
    EXPECT_NE(keys_of(), before) << experiment;
    edit("car.json", "50 g", "41 g");
    EXPECT_EQ(keys_of(), before) << experiment;
  }
}

/// The schedule of a case extends another: its own bytes stay.
TEST_F(Keys, DependOnFilesThatAHiddenCaseNames) {
  race(diagnosis);
  const std::string before = keys_of();
  edit("base.json", "0.7", "0.6");
  EXPECT_NE(keys_of(), before);
}

TEST_F(Keys, OfADiagnosisDependOnEveryEffectThatItMayFind) {
  const Registry shipped({plugin_dir()}), more({plugin_dir(), fixture_plugins("stranger")});
  EXPECT_EQ(keys_of(shipped), keys_of(more));  // a race uses what it names
  race(diagnosis);
  const auto with_shipped = keys_of(shipped);
  EXPECT_NE(with_shipped, keys_of(more));
  EXPECT_TRUE(read_manifest(out("keys")).libraries.contains("stranger.so"));
}

/// A planner `elm` of a user's own does not hide the estimator of that name.
TEST_F(Keys, NameLibrariesByTheKindOfTheirPlugins) {
  const Registry registry({fixture_plugins("namesake"), plugin_dir()});
  const std::string shipped = registry.find(abi::Kind::estimator, "elm").library.filename();
  race(offline);
  keys_of(registry);
  const Libraries libraries = read_manifest(out("keys")).libraries;
  EXPECT_TRUE(libraries.contains(shipped));
  EXPECT_FALSE(libraries.contains("namesake.so"));
}

}  // namespace test_keys
}  // namespace gripline::sweep
