#include "calibrate/effects/effect_trial.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace test_effect_trial {

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
  const auto candidates = candidates_beside(trial, testing_support::plugins(), {});
  ASSERT_FALSE(candidates.empty());
  for (const CandidateEffect& one : candidates)
    EXPECT_EQ(with_effect(trial.spec, one).vehicle.effects.size(), one.listed ? 1u : 2u) << one.id();
}

/// Single sessions lie further from the value than it is uncertain, by the root of their number.
TEST(OpenParameters, WhatIsDeterminedMayFollowTheSessionInsideItsRange) {
  const std::string pointer = "/plant/effects/steer_offset/params/d0";
  const Addition offset = added_effect("steer_offset");
  const auto width = [&](double sigma, FittedParameter::Status status, std::size_t sessions) {
    FittedParameter p{{}, 0.02, {0.01, 0.03, sigma, 0.9}, status};
    p.unknown.pointer = pointer;
    p.unknown.group = "command";
    p.unknown.sigma = 0.5;
    p.unknown.low = -0.1;
    p.unknown.high = std::numeric_limits<double>::infinity();
    Node world = testing_support::json(R"({"unknowns": {}})");
    open_parameters(world, {&offset, 1}, {&p, 1}, sessions);
    const Node* const listed = world.find("unknowns")->find(pointer);
    EXPECT_EQ(listed->find("low")->number(), -0.1);
    EXPECT_EQ(listed->find("high"), nullptr) << "it has no end there";
    const Node* const session = listed->find("session");
    return session == nullptr ? 0.0 : session->number();
  };
  using Status = FittedParameter::Status;
  EXPECT_DOUBLE_EQ(width(0.005, Status::determined, 1), 0.005);
  EXPECT_DOUBLE_EQ(width(0.005, Status::determined, 4), 0.01);
  EXPECT_EQ(width(1e3, Status::determined, 4), 0.5) << "the prior's";
  EXPECT_EQ(width(std::nan(""), Status::determined, 4), 0.0);
  EXPECT_EQ(width(0.005, Status::at_bound, 4), 0.0);
}

}  // namespace test_effect_trial
}  // namespace gripline::calibrate
