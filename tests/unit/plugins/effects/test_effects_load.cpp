#include "support/effect_bench.hpp"

namespace gripline {
namespace test_effects_load {

using test::EffectBench;

TEST(Mass, RaisesMassAndFrictionLimitButNotInertia) {
  EffectBench bench("mass");
  const auto q = bench.apply({0.1});
  EXPECT_NEAR(q.m, 2.2, 1e-14);
  EXPECT_NEAR(q.load_front, 1.21, 1e-14);
  EXPECT_NEAR(q.load_rear, 0.99, 1e-14);
  EXPECT_EQ(q.Iz, 0.5);
  bench.expect_exact_derivatives({0.1});
}

TEST(YawInertia, Scales) {
  EffectBench bench("yaw_inertia");
  EXPECT_NEAR(bench.apply({-0.2}).Iz, 0.4, 1e-14);
}

TEST(LoadTransfer, MovesLoadByTheMomentOfTheDriveForce) {
  EffectBench bench("load_transfer");
  const auto q = bench.apply({0.25});
  const double a = 2.0 / 2.0;  // Fd / m
  EXPECT_NEAR(q.load_front, 1.1 * (1.0 - 0.25 * (1.0 / 0.6) * a / 9.81), 1e-14);
  EXPECT_NEAR(q.load_rear, 0.9 * (1.0 + 0.25 * (1.0 / 0.4) * a / 9.81), 1e-14);
  bench.expect_exact_derivatives({0.25});
}

TEST(LoadTransfer, KeepsTheSumOfStaticLoads) {
  // Static loads are m g lr / L and m g lf / L: what the front loses the rear gains.
  EffectBench bench("load_transfer");
  bench.q.load_front = bench.q.load_rear = 1.0;
  const auto q = bench.apply({0.25});
  EXPECT_NEAR(q.load_front * 0.6 + q.load_rear * 0.4, 1.0, 1e-14);
}

/// Where more would move than an axle carries, it lifts off, and the other carries the car.
TEST(LoadTransfer, EndsWhereOneAxleCarriesTheCar) {
  EffectBench bench("load_transfer");
  bench.q.load_front = bench.q.load_rear = 1.0;
  for (const double force : {-40.0, 40.0}) {
    bench.q.drive_force = force;
    const auto q = bench.apply({1.0});
    EXPECT_NEAR(force > 0 ? q.load_front : q.load_rear, 0.0, 1e-14);
    EXPECT_NEAR(q.load_front * 0.6 + q.load_rear * 0.4, 1.0, 1e-14);
  }
}

TEST(CogShift, StaysBetweenTheAxles) {
  EffectBench bench("cog_shift");
  bench.q.lf = 0.2, bench.q.lr = 0.8;
  const auto q = bench.apply({-0.4});
  EXPECT_NEAR(q.lf, 0.01, 1e-14);
  EXPECT_NEAR(q.lr, 0.99, 1e-14);
  EXPECT_NEAR(q.load_front * 0.8 / 1.1 + q.load_rear * 0.2 / 0.9, 1.0, 1e-14);
}

TEST(CogShift, MovesGeometryAndLoadsTogether) {
  EffectBench bench("cog_shift");
  const auto q = bench.apply({0.05});
  EXPECT_NEAR(q.lf, 0.45, 1e-14);
  EXPECT_NEAR(q.lr, 0.55, 1e-14);
  EXPECT_NEAR(q.load_front, 1.1 * 0.55 / 0.6, 1e-14);
  EXPECT_NEAR(q.load_rear, 0.9 * 0.45 / 0.4, 1e-14);
  bench.expect_exact_derivatives({0.05});
}

TEST(Downforce, GrowsWithTheSquareOfSpeed) {
  EffectBench bench("downforce");
  const double factor = 1.0 + 0.2 * (4.0 / 5.0) * (4.0 / 5.0);
  const auto q = bench.apply({0.2});
  EXPECT_NEAR(q.load_front, 1.1 * factor, 1e-14);
  EXPECT_NEAR(q.load_rear, 0.9 * factor, 1e-14);
}

TEST(Downforce, LiftTakesNoMoreThanTheLoad) {
  EffectBench bench("downforce");
  bench.q.vx = 10.0;
  EXPECT_EQ(bench.apply({-0.9}).load_front, 0.0);
  EXPECT_EQ(bench.apply({-0.25}).load_front, 0.0);
  EXPECT_NEAR(bench.apply({-0.2}).load_rear, 0.9 * 0.2, 1e-14);
}

}  // namespace test_effects_load
}  // namespace gripline
