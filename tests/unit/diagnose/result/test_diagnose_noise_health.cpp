#include "diagnose/result/noise_health.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_noise_health {

using test::DiagnoseRig;
using testing::HasSubstr;

/// A reader is told where predictions are of commands that are straight and the fit's are not.
TEST(NoiseHealth, TellsOfLogsHeldOutWhoseCommandsAreNotBent) {
  const DiagnoseRig rig;
  const Log log = rig.simulate(rig.catalogue().null_model(), {.seconds = 5, .seed = 97});
  Problem problem = rig.problem({log});
  std::vector<measured::LogFile> held_out(2);
  held_out[0].name = "alike.csv";
  held_out[0].stretches = {log};
  held_out[0].stretches.front().dt *= 1.0 + 1e-4;
  held_out[1].name = "slower.csv";
  held_out[1].stretches = {DiagnoseRig::thinned(log)};
  EXPECT_TRUE(straight_commands(problem, held_out).empty()) << "no command is bent";
  problem.bend = {0.0, -0.125};
  const std::vector<measured::Finding> health = straight_commands(problem, held_out);
  ASSERT_EQ(health.size(), 1U);
  EXPECT_EQ(health.front().level, measured::Finding::Level::note);
  EXPECT_THAT(health.front().found, HasSubstr("slower.csv has one every 0.04 s, the log fitted every 0.02 s"));
}

}  // namespace test_diagnose_noise_health
}  // namespace gripline::diagnose
