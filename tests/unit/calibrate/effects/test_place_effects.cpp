#include "calibrate/effects/place_effects.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibrate/effects/effect_trial.hpp"
#include "support/calibrate_rig.hpp"
#include "support/host_support.hpp"

namespace gripline::calibrate {
namespace test_place_effects {

using namespace testing_support;

TEST(PlaceEffects, AreLeftOutAndNamed) {
  WorldSpec world =
      world_of(R"({"plant": {"effects": [{"plugin": "grade"}, {"plugin": "aero_drag", "params": {"a": 0.3}},
    {"plugin": "bank", "params": {"c3": 0.02}}, {"plugin": "friction_patch"}, {"plugin": "wind"},
    {"plugin": "steer_lag"}, {"plugin": "friction_drift"}, {"plugin": "vx_bias"}]}})");
  const auto gone = leave_out_place_effects(world.vehicle, world.car.car);
  EXPECT_THAT(gone, testing::ElementsAre("grade", "bank", "friction_patch"));
  std::vector<std::string> left;
  for (const PluginSpec& e : world.vehicle.effects) left.push_back(e.id());
  EXPECT_THAT(left, testing::ElementsAre("aero_drag", "wind", "steer_lag", "friction_drift", "vx_bias"));
}

/// A world's file keeps them: the others are counted in its list, not in what is left.
TEST(PlaceEffects, LeftOutTheyMoveNoValueOfTheOthers) {
  const test::CalibrateRig rig(test::small_car_world(R"({"plant": {"effects": [{"plugin": "friction_patch"},
    {"plugin": "front_grip", "params": {"k": 0.01}}, {"plugin": "front_grip", "params": {"k": 0.05}},
    {"plugin": "steer_offset", "params": {"d0": 0.02}}]}})"));
  WorldSpec spec = rig.spec;
  ASSERT_THAT(leave_out_place_effects(spec.vehicle, spec.car.car), testing::ElementsAre("friction_patch"));
  const Trial trial(spec, test::CalibrateRig::options(spec));
  ASSERT_NE(trial.find("/plant/effects/steer_offset/params/d0"), nullptr);
  ASSERT_NE(trial.find("/plant/effects/2/params/k"), nullptr);
  EXPECT_EQ(trial.find("/plant/effects/0/params/k"), nullptr);
  Node written = rig.tree;
  for (const ParameterPlace& place : trial.places)
    if (place.pointer.starts_with("/plant/effects/")) set_value(written, place.pointer, trial.params[place.index]);
  EXPECT_EQ(find_pointer(written, "/plant/effects/0/params"), nullptr);
  EXPECT_EQ(find_pointer(written, "/plant/effects/1/params/k")->number(), 0.01);
  EXPECT_EQ(find_pointer(written, "/plant/effects/2/params/k")->number(), 0.05);
  EXPECT_EQ(find_pointer(written, "/plant/effects/3/params/d0")->number(), 0.02);
}

}  // namespace test_place_effects
}  // namespace gripline::calibrate
