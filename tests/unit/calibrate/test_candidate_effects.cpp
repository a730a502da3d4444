#include "calibrate/candidate_effects.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace {

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

}  // namespace
}  // namespace gripline::calibrate
