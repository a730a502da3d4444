#include "diagnose/inference/late_place.hpp"

#include <gtest/gtest.h>

#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_late_place {

using test::DiagnoseRig;

/// A log of a car that drives at 2 m/s.
LogFile at_two_metres_a_second() {
  Log log;
  for (int k = 0; k < 10; ++k) {
    log.command.push_back({0.0, 0.0});
    log.reading.insert(log.reading.end(), {0.04 * k, 0.0, 0.0, 2.0, 0.0, 0.0});
  }
  LogFile file;
  file.stretches.push_back(std::move(log));
  return file;
}

std::optional<ChannelDelay> delay_for(const DiagnoseRig& rig, const ModelSpec& model) {
  Fit found;
  found.model = model;
  const LogFile file = at_two_metres_a_second();
  return delay_for_lever(rig.catalogue(), found, {&file, 1});
}
std::optional<ChannelDelay> delay_for(const DiagnoseRig& rig, double ahead) {
  return delay_for(rig, rig.with("pose_lever", {ahead, 0.0}));
}

TEST(LatePlace, ALeverBehindIsADelay) {
  const DiagnoseRig rig;
  const auto late = delay_for(rig, -0.1);
  ASSERT_TRUE(late);
  EXPECT_EQ(late->name(), "position");
  EXPECT_DOUBLE_EQ(late->seconds, 0.05);
  EXPECT_LT(late->low, 0.04);
  EXPECT_GT(late->high, 0.06);
}

TEST(LatePlace, OtherLeversAreNone) {
  const DiagnoseRig rig;
  EXPECT_FALSE(delay_for(rig, 0.1)) << "a place that is shown early";
  EXPECT_FALSE(delay_for(rig, -0.03)) << "less than a sample";
  EXPECT_FALSE(delay_for(rig, -2.0)) << "a second";
  EXPECT_FALSE(delay_for(rig, rig.catalogue().null_model()));
}

TEST(LatePlace, TheDelayTakesTheLeversPlaceInTheModel) {
  DiagnoseRig rig;
  rig.trust({"Df"}, 0.05);
  ModelSpec found = rig.with(rig.with("pose_lever", {-0.1, 0.0}), "drive_gain", {0.1});
  found.nuisance.front() *= 1.02;
  rig.catalogue().allow_for_late_pose(0, 0.007, 0.01);
  const ModelSpec model = with_delays_for_lever(rig.catalogue(), found);
  EXPECT_EQ(rig.catalogue().name(model), "drive_gain");
  EXPECT_EQ(model.values.front(), found.values[found.position(rig.catalogue().find("drive_gain"))]);
  ASSERT_EQ(model.nuisance.size(), 2U);
  EXPECT_EQ(model.nuisance[0], found.nuisance[0]);
  EXPECT_EQ(model.nuisance[1], 0.007);
}

}  // namespace test_diagnose_late_place
}  // namespace gripline::diagnose
