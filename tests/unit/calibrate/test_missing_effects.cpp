#include "calibrate/missing_effects.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace {

using test::CalibrateRig;
using test::small_car_world;

/// A world that knows nothing of pedals and steering, and a log of a car with these effects.
MissingEffects found_in_log_of(const char* effects) {
  const CalibrateRig truth(small_car_world(effects));
  const CalibrateRig nominal(small_car_world(R"({"plant": {"effects": []}, "unknowns": {
      "/plant/params/Bf": {"group": "tyres", "sigma": 0.3, "scale": "log"},
      "/plant/params/Cm1": {"group": "drive", "sigma": 0.3, "scale": "log"}}})"));
  std::list<measured::SessionFile> files(1);
  files.front().session = test::drive(truth.vehicle.car(), {.seconds = 60, .noise = 1});
  files.front().row_step = 0.02;
  MissingOptions options;
  options.fit.slowest = 0.5;
  options.fit.starts = 60;
  return find_missing(nominal.tree, nominal.spec, testing_support::plugins(), measured::gripline_map(), files, {},
                      options, ".");
}

const MissingEffect* find(const MissingEffects& found, const std::string& effect) {
  const auto at = std::ranges::find(found.named, effect, &MissingEffect::effect);
  return at == found.named.end() ? nullptr : &*at;
}

TEST(MissingEffects, DeadZoneAndSteeringOffsetAreNamedWithTheirSizesAndStandInTheWorld) {
  const MissingEffects found = found_in_log_of(R"({"plant": {"effects": [
      {"plugin": "throttle_dead_zone", "params": {"z": 0.12}}, {"plugin": "steer_offset", "params": {"d0": 0.03}}]}})");
  for (const auto& [effect, value, close] :
       {std::tuple("throttle_dead_zone", 0.12, 0.02), {"steer_offset", 0.03, 0.003}}) {
    const MissingEffect* const named = find(found, effect);
    ASSERT_NE(named, nullptr) << effect;
    EXPECT_TRUE(named->change.helps()) << effect;
    EXPECT_FALSE(named->measurement);
    ASSERT_EQ(named->params.size(), 1u);
    EXPECT_NEAR(named->params.front().value, value, close) << effect;
  }
  EXPECT_LT(found.found, 0.5 * found.calibrated);
  EXPECT_LT(found.calibrated, found.given);
  const CalibrateRig again(found.world);
  EXPECT_EQ(again.spec.vehicle.effects.size(), found.named.size());
}

TEST(MissingEffects, NothingIsNamedWhereNothingIsMissing) {
  const MissingEffects found = found_in_log_of(R"({"plant": {"params": {"Cm1": 14}, "effects": []}})");
  EXPECT_TRUE(found.named.empty()) << found.named.front().effect;
}

}  // namespace
}  // namespace gripline::calibrate
