#include "calibrate/effects/place_effects.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

}  // namespace test_place_effects
}  // namespace gripline::calibrate
