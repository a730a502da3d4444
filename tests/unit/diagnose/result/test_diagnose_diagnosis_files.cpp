#include "diagnose/result/diagnosis_files.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>

#include "support/diagnose_rig.hpp"
#include "support/host_support.hpp"

namespace gripline::diagnose {
namespace test_diagnose_diagnosis_files {

using test::DiagnoseRig;

/// A reader of numbers alone must see that one is no estimate.
TEST(DiagnoseDiagnosisFiles, AParameterAtAnEndOfItsRangeSaysWhich) {
  Diagnosis d;
  NamedEffect& offset = d.named.emplace_back();
  offset.effect = "yawrate_bias";
  offset.params = {{"b", "rad/s", -0.1, -0.11, -0.09, "low"}};
  NamedEffect& lag = d.named.emplace_back();
  lag.effect = "steer_lag";
  lag.params = {{"tau", "s", 0.04, 0.038, 0.042}};
  const Node::Array named = diagnosis_json(d).find("named")->array();
  ASSERT_EQ(named.size(), 2u);
  ASSERT_NE(named[0].find("at_end"), nullptr);
  EXPECT_EQ(named[0].find("at_end")->find("b")->text(), "low");
  EXPECT_EQ(named[0].find("params")->find("b")->number(), -0.1);
  EXPECT_EQ(named[1].find("at_end"), nullptr);
}

/// One that cannot tell would read as a doubt of the delay.
TEST(DiagnoseDiagnosisFiles, ADelayThatNothingWasPredictedWithoutHasNoRollout) {
  Diagnosis d;
  const auto delay = [&](const char* effect) -> NamedEffect& {
    NamedEffect& one = d.delays.emplace_back();
    one.effect = effect;
    one.params = {{"T", "s", 0.14, 0.13, 0.15}};
    return one;
  };
  delay("position_delay");
  delay("yaw_delay").rollout = {-0.5, -0.6, -0.4};
  d.named.emplace_back().effect = "steer_lag";
  const Node::Array named = diagnosis_json(d).find("named")->array();
  ASSERT_EQ(named.size(), 3u);
  EXPECT_EQ(named[0].find("rollout"), nullptr);
  ASSERT_NE(named[1].find("rollout"), nullptr);
  EXPECT_EQ(named[1].find("rollout")->find("change")->number(), -0.5);
  EXPECT_NE(named[2].find("rollout"), nullptr);
}

/// Evidence and a decrease of errors are not one number: each has its key, and only one is there.
TEST(DiagnoseDiagnosisFiles, EvidenceAndADecreaseOfErrorsHaveKeysOfTheirOwn) {
  Diagnosis d;
  d.ranking = {{.effect = "steer_lag", .gain = 812.4}, {.effect = "aero_drag", .less_error = 0.25}};
  const Node::Array ranking = diagnosis_json(d).find("ranking")->array();
  ASSERT_EQ(ranking.size(), 2u);
  EXPECT_EQ(ranking[0].find("gain")->number(), 812.4);
  EXPECT_EQ(ranking[0].find("less_error"), nullptr);
  EXPECT_EQ(ranking[1].find("less_error")->number(), 0.25);
  EXPECT_EQ(ranking[1].find("gain"), nullptr);
}

/// The augmented world's list of effects takes the place of the world's: what a third party's effect is told, a table
/// for one, must be in it, in the words that are read.
TEST(DiagnoseDiagnosisFiles, ThePatchHasEffectsAsTheyAreRead) {
  const DiagnoseRig rig({}, {testing_support::build_dir() / "tests/plugins/typed_effects"},
                        R"({"plant": {"effects": [{"plugin": "typed.drag_table", "note": "of the maker",
                            "params": {"shape": "none", "on": false, "table": [[0, 1], [2.5, -3]]}}]}})");
  const Diagnoser diagnoser(rig.world(), rig.registry(), {});
  Diagnosis d;
  d.fit.model = rig.with("typed.drag", {0.3});
  const Node patch = world_patch(d, diagnoser, rig.world());
  const Node::Array& effects = patch.find("plant")->find("effects")->array();
  ASSERT_EQ(effects.size(), 2U);
  const bool own_first = effects[0].find("note") != nullptr;
  const Node &own = effects[own_first ? 0 : 1], &found = effects[own_first ? 1 : 0];
  EXPECT_EQ(own.find("note")->text(), "of the maker");
  EXPECT_EQ(found.find("params")->find("shape")->text(), "square");
  EXPECT_TRUE(found.find("params")->find("on")->boolean());
  EXPECT_EQ(found.find("params")->find("a")->number(), 0.3);
  Errors errors;
  const Node world = merge(load_json(testing_support::source_dir() / "worlds/diagnose_rc43.json"), patch);
  const WorldSpec again = read_world(world, rig.registry(), errors);
  errors.throw_if_any();
  const PluginSpec &before = rig.world().vehicle.effects.front(), &after = again.vehicle.effects[own_first ? 0 : 1];
  EXPECT_EQ(after.id(), "typed.drag_table");
  EXPECT_EQ(after.numbers(), before.numbers());
  EXPECT_EQ(*after.tables.front(), *before.tables.front());
}

/// A table's file is named beside the world's file, and the augmented world lies elsewhere.
TEST(DiagnoseDiagnosisFiles, TablesOfFilesAreWrittenByTheirRows) {
  const testing_support::Folder folder;
  std::ofstream(folder / "drag.csv") << "speed,drag\n0,1\n2,3\n";
  const DiagnoseRig rig({}, {testing_support::build_dir() / "tests/plugins/typed_effects"},
                        R"({"plant": {"effects": [{"plugin": "typed.drag_table", "params": {"table": ")" +
                            (folder / "drag.csv").string() + R"("}}]}})");
  const Diagnoser diagnoser(rig.world(), rig.registry(), {});
  Diagnosis d;
  d.fit.model = rig.catalogue().null_model();
  const Node patch = world_patch(d, diagnoser, rig.world());
  const Node& table = *patch.find("plant")->find("effects")->array().front().find("params")->find("table");
  ASSERT_TRUE(table.is_array());
  EXPECT_EQ(table.array()[1].array()[1].number(), 3.0);
}

/// An effect that was left out after reading would shift the words of those behind it.
TEST(DiagnoseDiagnosisFiles, AWorldWithoutAllEffectsOfItsFileIsRefused) {
  const DiagnoseRig rig({}, {}, R"({"plant": {"effects": [{"plugin": "steer_lag", "params": {"tau": 0.02}},
                                                          {"plugin": "aero_drag", "params": {"a": 0.1}}]}})");
  WorldSpec less = rig.world();
  less.vehicle.effects.erase(less.vehicle.effects.begin());
  const Diagnoser diagnoser(less, rig.registry(), {});
  Diagnosis d;
  d.fit.model = diagnoser.catalogue().null_model();
  EXPECT_THROW((void)world_patch(d, diagnoser, less), std::logic_error);
}

}  // namespace test_diagnose_diagnosis_files
}  // namespace gripline::diagnose
