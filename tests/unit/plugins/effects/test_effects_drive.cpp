#include "car/instant.hpp"
#include "support/effect_bench.hpp"
#include "support/vehicle_checks.hpp"

namespace gripline {
namespace test_effects_drive {

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

/// Force at 2 m/s under full brakes of a model whose motor brakes, with an effect; brakes have a heat of 1.
double braking_force(const char* id, const char* effect, double param) {
  const rig::TestedModel model(id, {{"Cb", 0}});
  const EffectBench bench(effect);
  StagedCar car(*model.model, model.params);
  car.add(bench.effect(), {param}, effect);
  const double motion[] = {0, 0, 0, 2, 0, 0}, heat = 1;
  double rate = 0;
  const Place at;
  InstantBatch<double> instant(motion, {-1, 0, 0}, at, 0.02, Hold::zoh);
  instant.batch.memory = &heat;
  instant.batch.memory_rate = &rate;
  Quantities<double> q{};
  car.quantities(instant.batch, &q);
  return q.drive_force;
}

/// The rule of effects.md, on which published fits rest.
TEST(DriveEffects, AMotorThatBrakesIsABrake) {
  const double bare = -(0.287 - 0.0545 * 2);
  for (const char* model : {"dynamic", "kinematic", "ekinematic"}) {
    EXPECT_DOUBLE_EQ(braking_force(model, "drive_gain", 0.2), bare) << model;
    EXPECT_DOUBLE_EQ(braking_force(model, "back_emf", 0.1), bare) << model;
    EXPECT_DOUBLE_EQ(braking_force(model, "power_limit", 0.01), bare) << model;
    EXPECT_NEAR(braking_force(model, "brake_gain", 0.25), 1.25 * bare, 1e-15) << model;
    EXPECT_NEAR(braking_force(model, "brake_fade", 0.3), 0.7 * bare, 1e-15) << model;
  }
}

TEST(BrakeFade, BrakesHeatBackwardsToo) {
  EffectBench bench("brake_fade");
  bench.memory = {0.0};
  bench.q.d = -0.5;
  bench.q.vx = -4.0;
  bench.apply({0.3});
  EXPECT_NEAR(bench.memory_rate[0], 0.5 * 0.5 * (4.0 / 5.0), 1e-14);
}

TEST(BrakeFade, NeverTurnsTheBrakeAround) {
  EffectBench bench("brake_fade");
  bench.memory = {10.0};
  EXPECT_EQ(bench.apply({0.5}).brake, 0.0);
}

}  // namespace test_effects_drive
}  // namespace gripline
