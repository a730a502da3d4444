#include <cmath>

#include "support/effect_bench.hpp"

namespace gripline {
namespace test_effects_tyre {

using test::EffectBench;

TEST(FrictionScale, ScalesBothPeaks) {
  EffectBench bench("friction_scale");
  const auto q = bench.apply({-0.1});
  EXPECT_NEAR(q.peak_front, 8.1, 1e-14);
  EXPECT_NEAR(q.peak_rear, 6.3, 1e-14);
}

TEST(FrictionDrift, IsLinearInTime) {
  EffectBench bench("friction_drift");
  bench.at.t = 30.0;
  EXPECT_NEAR(bench.apply({-0.2}).peak_front, 8.1, 1e-14);
  bench.at.t = 0.0;
  EXPECT_EQ(bench.apply({-0.2}).peak_front, 9.0);
}

TEST(FrictionPatch, IsAWindowOfTheLap) {
  EffectBench bench("friction_patch");
  bench.at.lap_fraction = 0.3;
  const double inside = bench.apply({-0.2, 0.3, 0.1}).peak_rear;
  const double middle = std::tanh(0.05 / 0.012);
  EXPECT_NEAR(inside, 7.0 * (1.0 - 0.2 * middle), 1e-12);
  bench.at.lap_fraction = 0.35;  // its edge: half of the change
  EXPECT_NEAR(bench.apply({-0.2, 0.3, 0.1}).peak_rear, 7.0 * (1.0 - 0.1 * std::tanh(0.1 / 0.012)), 1e-12);
  bench.at.lap_fraction = 0.8;
  EXPECT_NEAR(bench.apply({-0.2, 0.3, 0.1}).peak_rear, 7.0, 1e-12);
}

TEST(FrictionPatch, WrapsAroundTheStart) {
  EffectBench bench("friction_patch");
  bench.at.lap_fraction = 0.02;
  const double there = bench.apply({-0.2, 0.98, 0.1}).peak_front;
  bench.at.lap_fraction = 0.54;
  EXPECT_NEAR(bench.apply({-0.2, 0.5, 0.1}).peak_front, there, 1e-12);
  bench.expect_exact_derivatives({-0.2, 0.5, 0.1});
}

TEST(Grip, OneAxleEach) {
  EffectBench front("front_grip"), rear("rear_grip");
  EXPECT_NEAR(front.apply({0.1}).peak_front, 9.9, 1e-14);
  EXPECT_EQ(front.apply({0.1}).peak_rear, 7.0);
  EXPECT_NEAR(rear.apply({0.1}).peak_rear, 7.7, 1e-14);
  EXPECT_EQ(rear.apply({0.1}).peak_front, 9.0);
}

TEST(Stiffness, OneAxleEach) {
  EffectBench front("front_stiff"), rear("rear_stiff");
  EXPECT_NEAR(front.apply({0.25}).stiff_front, 5.0, 1e-14);
  EXPECT_EQ(front.apply({0.25}).stiff_rear, 5.0);
  EXPECT_NEAR(rear.apply({-0.2}).stiff_rear, 4.0, 1e-14);
  EXPECT_EQ(rear.apply({-0.2}).stiff_front, 4.0);
}

TEST(CombSlip, TakesFromTheRearWhatDriveUses) {
  EffectBench bench("comb_slip");
  EXPECT_NEAR(bench.apply({0.8}).peak_rear, 7.0 * std::sqrt(1.0 - 0.8 * (2.0 / 7.0) * (2.0 / 7.0)), 1e-14);
  bench.expect_exact_derivatives({0.8});
  bench.q.drive_force = 100.0;
  EXPECT_NEAR(bench.apply({0.8}).peak_rear, 7.0 * std::sqrt(0.05), 1e-14);
}

TEST(CombSlip, ActsAfterEveryOtherFactorOfTheRearPeak) {
  const int last = EffectBench("comb_slip").entry().decl->precedence;
  for (const char* id : {"friction_scale", "friction_drift", "friction_patch", "front_grip", "rear_grip"})
    EXPECT_LT(EffectBench(id).entry().decl->precedence, last) << id;
}

}  // namespace test_effects_tyre
}  // namespace gripline
