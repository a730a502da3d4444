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

}  // namespace
}  // namespace gripline::calibrate
