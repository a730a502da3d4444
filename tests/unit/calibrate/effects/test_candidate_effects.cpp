#include "calibrate/effects/candidate_effects.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "calibrate/effects/effect_trial.hpp"
#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace test_candidate_effects {

std::vector<std::string> ids(bool road) {
  const test::CalibrateRig rig;
  std::vector<std::string> names;
  for (const CandidateEffect& c :
       candidate_effects(rig.spec.vehicle, rig.spec.car.car, testing_support::plugins(), road))
    names.push_back(c.id());
  return names;
}

TEST(CandidateEffects, PedalsMapsAndFramesAreAmongThem) {
  const auto names = ids(false);
  for (const char* one : {"throttle_dead_zone", "throttle_curve", "steer_map", "back_emf", "turning_drag", "vx_bias",
                          "pose_yaw", "front_grip"})
    EXPECT_THAT(names, testing::Contains(one));
}

TEST(CandidateEffects, WhatIsThereOrKnownOrCannotBeTestedIsNot) {
  const auto names = ids(false);
  for (const char* one : {"steer_offset", "mass", "cog_shift", "steer_lag", "input_delay", "bank", "friction_patch"})
    EXPECT_THAT(names, testing::Not(testing::Contains(one)));
  EXPECT_THAT(ids(true), testing::Contains("bank"));
}

/// All are tried in one car: one that is not neutral would change what is found of the others.
TEST(CandidateEffects, BeginWhereTheyDoNothing) {
  const test::CalibrateRig rig;
  std::size_t fitted = 0;
  for (const CandidateEffect& c :
       candidate_effects(rig.spec.vehicle, rig.spec.car.car, testing_support::plugins(), true)) {
    const auto params = c.entry->params();
    for (std::size_t i = 0; i < params.size(); ++i) {
      if (!params[i].fit) continue;
      EXPECT_EQ(c.numbers[i], params[i].neutral) << c.id() << " " << params[i].name;
      ++fitted;
    }
    if (c.id() == "wind" || c.id() == "plane_tilt") {
      EXPECT_EQ(c.tested.size(), 2u) << c.id();
    } else if (c.id() == "friction_patch") {
      EXPECT_EQ(c.tested.size(), 1u);  // place and length move nothing while it is as strong as none
    }
  }
  EXPECT_GT(fitted, 20u);
}

/// A parameter that a world's effect has at a value that does nothing is a candidate; one with a value of its own is
/// known.
TEST(IdleParameters, AreThoseThatDoNothingAsListed) {
  const test::CalibrateRig rig(test::small_car_world(R"({"plant": {"effects": [
      {"plugin": "steer_map", "params": {"g": 0.9}}, {"plugin": "steer_lag", "params": {"tau": 0.05}},
      {"plugin": "steer_offset", "params": {"d0": 0.02}}, {"plugin": "friction_patch", "params": {"k": 0}},
      {"plugin": "vx_bias", "params": {"b": 0}}]}})"));
  std::vector<std::string> pointers;
  const auto places = parameter_places(rig.spec, rig.forecaster);
  for (const CandidateEffect& one : idle_parameters(rig.spec.vehicle, rig.spec.car.car, false)) {
    const auto place = std::ranges::find(places, one.listed.value(), &ParameterPlace::index);
    pointers.push_back(place->pointer.substr(std::string("/plant/effects/").size()));
    EXPECT_EQ(one.tested, one.open);
    EXPECT_EQ(one.open.size(), 1u);
  }
  EXPECT_THAT(pointers, testing::UnorderedElementsAre("steer_map/params/a", "steer_map/params/c", "vx_bias/params/b"));
}

TEST(IdleParameters, OfAnEffectThatIsListedTwiceAreNone) {
  const test::CalibrateRig rig(test::small_car_world(R"({"plant": {"effects": [
      {"plugin": "steer_offset", "params": {"d0": 0}}, {"plugin": "steer_offset", "params": {"d0": 0}}]}})"));
  EXPECT_TRUE(idle_parameters(rig.spec.vehicle, rig.spec.car.car, false).empty());
}

/// Scores of all candidates on a log of a car that differs by `truth` from the nominal one, whose Bf, Cm1 and Iz move;
/// Iz is known to a per cent.
std::map<std::string, EffectScore> scores_of(const char* truth) {
  const test::CalibrateRig driven(test::small_car_world(truth));
  const test::CalibrateRig nominal;
  const measured::Session session = test::drive(driven.vehicle.car(), {.seconds = 40, .noise = 1});
  std::vector<FitLog> logs;
  logs.emplace_back(session, 0.02, std::vector<double>{0.5, 1.0}, 0.5, 0.5);
  std::vector<Unknown> fitted;
  for (const ParameterPlace& place : parameter_places(nominal.spec, nominal.forecaster))
    for (const auto& [name, sigma] : {std::pair("Bf", 1.0), {"Cm1", 5.0}, {"Iz", 1e-4}})
      if (place.pointer == std::string("/plant/params/") + name) {
        fitted.push_back(unknown_at(place, nominal.forecaster.defaults()[place.index]));
        fitted.back().sigma = sigma;
      }
  EXPECT_EQ(fitted.size(), 3u);
  const auto candidates =
      candidate_effects(nominal.spec.vehicle, nominal.spec.car.car, testing_support::plugins(), false);
  Weighing weighing;
  weighing.horizon = {0.5, 1.0};
  std::map<std::string, EffectScore> scores;
  for (EffectScore& one : score_candidates(nominal.vehicle.car(), candidates, test::CalibrateRig::options(nominal.spec),
                                           logs, nominal.forecaster.defaults(), fitted, weighing))
    scores[candidates[one.candidate].id()] = std::move(one);
  return scores;
}

/// What an unknown of the world does already is no candidate, however little its prior lets it move.
TEST(EffectScores, WhatTheWorldsUnknownsStandForIsNoCandidate) {
  const auto scores = scores_of(R"({"plant": {"params": {"Iz": 0.02}}, "car": {"Iz": 0.02}})");
  EXPECT_FALSE(scores.contains("yaw_inertia"));
  EXPECT_FALSE(scores.contains("drive_gain"));
  EXPECT_TRUE(scores.contains("back_emf"));
}

/// A gain that lies beyond a parameter's range is none: less grip than nothing, a dead zone below 0.
TEST(EffectScores, StayInsideTheRangesOfTheParameters) {
  const auto scores = scores_of(R"({"plant": {"params": {"Df": 1.5, "Dr": 1.5}}})");
  ASSERT_TRUE(scores.contains("friction_scale"));
  for (const PluginEntry& entry : testing_support::plugins().entries()) {
    const auto found = scores.find(entry.decl->id);
    if (found == scores.end() || found->second.value.size() != 1) continue;
    const abi::ParamDecl& p = entry.params().front();
    const double neutral = p.fit ? p.neutral : p.default_value;
    EXPECT_GE(neutral + found->second.value.front(), p.lo) << found->first;
    EXPECT_LE(neutral + found->second.value.front(), p.hi) << found->first;
  }
}

std::map<std::string, SteeringAsymmetry> asymmetries_beside(const char* world) {
  const test::CalibrateRig rig(test::small_car_world(world));
  const Trial trial(rig.spec, test::CalibrateRig::options(rig.spec));
  std::map<std::string, SteeringAsymmetry> of;
  for (const CandidateEffect& one : candidates_beside(trial, testing_support::plugins(), {}))
    of[addition_of(one, trial).name] = one.asymmetry;
  return of;
}

TEST(SteeringAsymmetries, AreOffsetsAndOneSidedCurves) {
  const auto of = asymmetries_beside(R"({"plant": {"effects": [{"plugin": "steer_map", "params": {"g": 0.9}}]}})");
  EXPECT_EQ(of.at("steer_offset"), SteeringAsymmetry::offset);
  EXPECT_EQ(of.at("steer_map.a"), SteeringAsymmetry::curve);
  for (const char* const alike : {"steer_map.c", "steer_gain", "throttle_dead_zone", "torque_vec", "yawrate_bias"})
    EXPECT_EQ(of.at(alike), SteeringAsymmetry::none) << alike;
  EXPECT_EQ(asymmetries_beside(R"({"plant": {"effects": []}})").at("steer_map"), SteeringAsymmetry::curve);
}

/// What a world knows already is no asymmetry of what it may lack.
TEST(SteeringAsymmetries, AreWhatACandidateChanges) {
  const auto of =
      asymmetries_beside(R"({"plant": {"effects": [{"plugin": "steer_map", "params": {"g": 0.9, "a": -0.5}}]}})");
  EXPECT_EQ(of.at("steer_map.c"), SteeringAsymmetry::none);
}

}  // namespace test_candidate_effects
}  // namespace gripline::calibrate
