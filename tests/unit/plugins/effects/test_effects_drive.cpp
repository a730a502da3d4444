#include "support/effect_bench.hpp"

namespace gripline {
namespace {

using test::EffectBench;

TEST(BackEmf, AddsAShareOfTheDriveForceAtTheReferenceSpeed) {
  EffectBench bench("back_emf");
  EXPECT_NEAR(bench.apply({0.1}).emf, 1.5 + 0.1 * 10.0 / 5.0, 1e-14);
  bench.expect_exact_derivatives({0.1});
}

TEST(DriveGain, ScalesTheMotorAlone) {
  EffectBench bench("drive_gain");
  const auto q = bench.apply({-0.2});
  EXPECT_NEAR(q.motor, 8.0, 1e-14);
  EXPECT_EQ(q.emf, bench.q.emf);
  EXPECT_EQ(q.brake, bench.q.brake);
}

TEST(DriveGain, ActsAfterBackEmfWhoseForceIsTheNominalOne) {
  const EffectBench emf("back_emf"), gain("drive_gain");
  EXPECT_LT(emf.entry().decl->precedence, gain.entry().decl->precedence);
}

TEST(BrakeGain, ScalesTheBrake) {
  EffectBench bench("brake_gain");
  EXPECT_NEAR(bench.apply({0.25}).brake, 10.0, 1e-14);
}

TEST(BrakeFade, HeatGrowsWithBrakingAndLeaksAway) {
  EffectBench bench("brake_fade");
  bench.memory = {0.6};
  bench.q.d = -0.5;
  const auto q = bench.apply({0.3});
  EXPECT_NEAR(bench.memory_rate[0], 0.5 * 0.5 * (4.0 / 5.0) - 0.6 / 20.0, 1e-14);
  EXPECT_NEAR(q.brake, 8.0 * (1.0 - 0.3 * 0.6), 1e-14);
  bench.expect_exact_derivatives({0.3});
  bench.q.d = 0.5;
  bench.apply({0.3});
  EXPECT_NEAR(bench.memory_rate[0], -0.03, 1e-14);
}

TEST(BrakeFade, NeverTurnsTheBrakeAround) {
  EffectBench bench("brake_fade");
  bench.memory = {10.0};
  EXPECT_EQ(bench.apply({0.5}).brake, 0.0);
}

}  // namespace
}  // namespace gripline
