#include "calibrate/effects/effect_trial.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace {

/// A world with a servo map of which nothing is said to be unknown.
Trial mapped() {
  const test::CalibrateRig rig(
      test::small_car_world(R"({"plant": {"effects": [{"plugin": "steer_map", "params": {"g": 0.9}}]}})"));
  return {rig.spec, test::CalibrateRig::options(rig.spec)};
}

Unknown unknown_of(const Trial& trial, const std::string& pointer) {
  const ParameterPlace* const place = trial.find(pointer);
  return unknown_at(*place, trial.params[place->index]);
}

std::vector<std::string> names_beside(const Trial& trial, std::span<const FittedParameter> known = {}) {
  std::vector<std::string> names;
  for (const CandidateEffect& one : candidates_beside(trial, testing_support::plugins(), known))
    names.push_back(addition_of(one, trial).name);
  return names;
}

TEST(Addition, OwnsItsParametersAndNoOthers) {
  const Addition offset = added_effect("steer_offset");
  EXPECT_TRUE(offset.owns("/plant/effects/steer_offset/params/d0"));
  EXPECT_FALSE(offset.owns("/plant/effects/steer_map/params/a"));
  const Addition bend{"steer_map.c", "/plant/effects/steer_map/params/c", true};
  EXPECT_TRUE(bend.owns("/plant/effects/steer_map/params/c"));
  EXPECT_FALSE(bend.owns("/plant/effects/steer_map/params/a"));
}

TEST(CandidatesBeside, AreEffectsThatTheCarLacksAndIdleParametersThatNobodyFits) {
  Trial trial = mapped();
  EXPECT_THAT(names_beside(trial), testing::IsSupersetOf({"steer_offset", "steer_map.a", "steer_map.c"}));
  EXPECT_THAT(names_beside(trial), testing::Not(testing::Contains("steer_map.g"))) << "it does something";
  trial.unknowns.push_back(unknown_of(trial, "/plant/effects/steer_map/params/a"));
  EXPECT_THAT(names_beside(trial), testing::Not(testing::Contains("steer_map.a")));
}

/// What is kept at its prior is not idle: the logs were asked for it. Nor is what another parameter is the same as.
TEST(CandidatesBeside, LeaveOutWhatIsKnown) {
  Trial trial = mapped();
  FittedParameter kept{
      unknown_of(trial, "/plant/effects/steer_map/params/a"), 0.0, {}, FittedParameter::Status::at_bound};
  kept.unknown.same.push_back({"/plant/effects/steer_map/params/c", 0});
  const std::vector<std::string> names = names_beside(trial, {&kept, 1});
  EXPECT_THAT(names, testing::Not(testing::Contains("steer_map.a")));
  EXPECT_THAT(names, testing::Not(testing::Contains("steer_map.c")));
}

TEST(WithEffect, AListedParameterAddsNone) {
  const Trial trial = mapped();
  for (const CandidateEffect& one : candidates_beside(trial, testing_support::plugins(), {}))
    EXPECT_EQ(with_effect(trial.spec, one).vehicle.effects.size(), one.listed ? 1u : 2u) << one.id();
}

}  // namespace
}  // namespace gripline::calibrate
