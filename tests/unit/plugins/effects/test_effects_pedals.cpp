#include <cmath>

#include "support/effect_bench.hpp"

namespace gripline {
namespace test_effects_pedals {

using test::EffectBench;

/// A ramp of both commands; now is 0.5 s.
EffectBench after_a_ramp(const char* id) {
  EffectBench bench(id);
  for (int i = 0; i <= 25; ++i) bench.commands.push_back({0.02 * i, -0.01 * i});
  bench.now = 0.5;
  bench.q.d = 0.5;
  bench.q.delta = -0.25;
  bench.q.delta_rate = -0.5;
  return bench;
}

TEST(ThrottleDelay, DelaysTheThrottleAlone) {
  EffectBench bench = after_a_ramp("throttle_delay");
  const auto q = bench.apply({0.11});
  EXPECT_NEAR(q.d, 0.39, 1e-12);
  EXPECT_EQ(q.delta, -0.25);
  EXPECT_NEAR(bench.effect().look_back(std::vector{0.11}), 0.11, 0.0);
  bench.expect_exact_derivatives({0.11});
}

TEST(SteerDelay, DelaysTheSteeringAlone) {
  EffectBench bench = after_a_ramp("steer_delay");
  const auto q = bench.apply({0.11});
  EXPECT_EQ(q.d, 0.5);
  EXPECT_NEAR(q.delta, -0.195, 1e-12);
  EXPECT_NEAR(q.delta_rate, -0.5, 1e-12);
  bench.expect_exact_derivatives({0.11});
}

TEST(ThrottleDeadZone, EatsTheFirstBitAndKeepsFullThrottle) {
  EffectBench bench("throttle_dead_zone");
  bench.q.d = 0.04;
  EXPECT_EQ(bench.apply({0.05}).d, 0.0);
  bench.q.d = 1.0;
  EXPECT_NEAR(bench.apply({0.05}).d, 1.0, 1e-14);
  bench.q.d = 0.24;
  EXPECT_NEAR(bench.apply({0.05}).d, 0.2, 1e-14);
  bench.expect_exact_derivatives({0.05});
  bench.q.d = -0.3;  // brakes
  EXPECT_EQ(bench.apply({0.05}).d, -0.3);
}

TEST(ThrottleCurve, BendsThePedalAndLeavesItsEnds) {
  EffectBench bench("throttle_curve");
  for (const double d : {-0.5, 0.0, 1.0}) {
    bench.q.d = d;
    EXPECT_NEAR(bench.apply({1.7}).d, d, 1e-14);
  }
  bench.q.d = 0.25;
  EXPECT_NEAR(bench.apply({0.5}).d, 0.5, 1e-14);
  bench.expect_exact_derivatives({1.7});
}

TEST(SteerMap, IsACubicWithItsOwnSlopeInTheRate) {
  EffectBench bench("steer_map");
  bench.q.delta = 0.2;
  bench.q.delta_rate = 0.7;
  const auto q = bench.apply({0.9, 0.3, -0.5});
  EXPECT_NEAR(q.delta, 0.9 * 0.2 + 0.3 * 0.04 - 0.5 * 0.008, 1e-14);
  EXPECT_NEAR(q.delta_rate, 0.7 * (0.9 + 2 * 0.3 * 0.2 - 3 * 0.5 * 0.04), 1e-14);
  bench.expect_exact_derivatives({0.9, 0.3, -0.5});
}

TEST(SteerRateLimit, FollowsSmallMovesWithALagAndTurnsOnlySoFast) {
  EffectBench bench("steer_rate_limit");
  bench.q.delta = 0.2;
  EXPECT_EQ(bench.start_memory({5.0, 0.02}).front(), 0.2);
  const auto rate = [&](double off) {
    bench.memory = {0.2 - off};
    const auto q = bench.apply({5.0, 0.02});
    EXPECT_EQ(q.delta, 0.2 - off);
    EXPECT_EQ(q.delta_rate, bench.memory_rate.front());
    return q.delta_rate;
  };
  EXPECT_NEAR(rate(0.001), 0.001 / 0.02, 1e-5);  // a first-order lag
  EXPECT_NEAR(rate(0.6), 5.0, 1e-4);
  EXPECT_NEAR(rate(-0.6), -5.0, 1e-4);
  bench.memory = {0.1};
  bench.expect_exact_derivatives({5.0, 0.02});
}

TEST(PowerLimit, NeverGivesMoreThanThePowerNorThanTheMotor) {
  EffectBench bench("power_limit");
  const auto force = [](const Quantities<double>& q) { return q.motor - q.emf * q.vx; };
  const double before = force(bench.q);
  for (const double power : {1.0, 10.0, 16.0, 1e3, 1e6}) {
    const double after = force(bench.apply({power}));
    EXPECT_LE(after * bench.q.vx, power * (1 + 1e-12));
    EXPECT_LE(after, before);
    EXPECT_GE(after, 0.84 * std::min(before, power / bench.q.vx));
  }
  bench.expect_exact_derivatives({16.0});
  bench.q.vx = -1.0;  // reversing: nothing to limit
  EXPECT_EQ(force(bench.apply({1.0})), force(bench.q));
}

TEST(CorneringDrag, GrowsWithLateralAccelerationSquaredAgainstTheMotion) {
  EffectBench bench("cornering_drag");
  const double lateral = bench.q.vx * bench.q.omega;
  EXPECT_NEAR(bench.apply({0.01}).ax - bench.q.ax, -0.01 * lateral * lateral, 1e-14);
  bench.expect_exact_derivatives({0.01});
  bench.q.vx = -bench.q.vx;
  EXPECT_GT(bench.apply({0.01}).ax, bench.q.ax);
}

TEST(TurningDrag, GrowsWithTheYawRateEitherWayAgainstTheMotion) {
  EffectBench bench("turning_drag");
  for (const double omega : {1.2, -1.2}) {
    bench.q.omega = omega;
    EXPECT_NEAR(bench.apply({0.2}).ax - bench.q.ax, -0.2 * 1.2, 1e-14) << omega;
    bench.expect_exact_derivatives({0.2});
  }
  bench.q.vx = -bench.q.vx;
  EXPECT_NEAR(bench.apply({0.2}).ax - bench.q.ax, 0.2 * 1.2, 1e-14);
  bench.q.vx = 0.0;  // a car that turns where it stands is not set moving
  EXPECT_EQ(bench.apply({0.2}).ax, bench.q.ax);
  bench.q.vx = 0.01;
  EXPECT_NEAR(bench.apply({0.2}).ax - bench.q.ax, -0.1 * 1.2, 1e-14);
}

TEST(Pedals, DelaysComeFirstThenTheDeadZoneThenCurvesAndMaps) {
  const auto order = [](const char* id) { return EffectBench(id).entry().decl->precedence; };
  EXPECT_LT(order("throttle_delay"), order("throttle_dead_zone"));
  EXPECT_LT(order("throttle_dead_zone"), order("throttle_curve"));
  EXPECT_LT(order("steer_delay"), order("steer_map"));
  EXPECT_LT(order("steer_map"), order("steer_lag"));
}

}  // namespace test_effects_pedals
}  // namespace gripline
