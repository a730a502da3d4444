#include "diagnose/inference/noise_scoring.hpp"

#include <gtest/gtest.h>

#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_noise_scoring {

using test::DiagnoseRig;

/// Whatever noise was asked for before: also where commands become unknown between samples, and known again.
TEST(Innovations, AreOfTheNoiseAskedFor) {
  const DiagnoseRig rig;
  const Problem problem = rig.problem({rig.simulate(rig.catalogue().null_model(), {.seconds = 6, .seed = 726})});
  MeasuredNoise known;
  known.noise = rig.noise(problem, 2.0);
  known.model = rig.catalogue().null_model();
  MeasuredNoise unknown = known, slow = known;
  unknown.noise.command.steady = {0.1, 0.02};
  slow.noise_time = 1.0;
  const auto anew = [&](const MeasuredNoise& m) { return cost_of(Innovations(problem).under(m)); };
  EXPECT_GT(std::abs(anew(unknown) - anew(known)), 1.0);
  EXPECT_GT(std::abs(anew(slow) - anew(known)), 1.0);
  Innovations kept(problem);
  for (const MeasuredNoise* m : {&known, &unknown, &known, &slow, &unknown, &slow})
    EXPECT_EQ(cost_of(kept.under(*m)), anew(*m));
}

}  // namespace test_diagnose_noise_scoring
}  // namespace gripline::diagnose
