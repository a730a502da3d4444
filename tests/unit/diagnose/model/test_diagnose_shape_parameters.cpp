#include <gtest/gtest.h>

#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_shape_parameters {

using test::DiagnoseRig;

/// The place and length of a patch of no depth do nothing; a knot of a profile along the lap acts alone.
TEST(ShapeParameters, AreThePlaceAndLengthOfAPatchAndNoKnotOfAProfile) {
  const DiagnoseRig rig;
  const auto candidate = [&](const char* id) -> const Candidate& {
    return rig.catalogue().candidates()[rig.catalogue().find(id)];
  };
  const Candidate& patch = candidate("friction_patch");
  EXPECT_STREQ(patch.decl(patch.strength).name, "k");
  ASSERT_EQ(patch.shapes.size(), 2U);
  EXPECT_STREQ(patch.decl(patch.shapes[0]).name, "s0");
  EXPECT_STREQ(patch.decl(patch.shapes[1]).name, "w");
  for (const char* id : {"bank", "grade", "aero_drag", "brake_gain", "vx_bias", "pose_lever", "wind", "plane_tilt"})
    EXPECT_TRUE(candidate(id).shapes.empty()) << id;
}

}  // namespace test_diagnose_shape_parameters
}  // namespace gripline::diagnose
