#include <cmath>

#include "support/effect_bench.hpp"

namespace gripline {
namespace test_effects_command {

using test::EffectBench;

TEST(InputDelay, CommandsAreThoseOfTheFirstOrderHoldAgo) {
  EffectBench bench("input_delay");
  bench.commands = {{0.0, 0.0}, {1.0, 0.1}, {0.0, 0.3}, {0.5, 0.3}};
  bench.now = 0.06;
  const auto q = bench.apply({0.025});  // 0.035 s: three quarters between samples 1 and 2
  EXPECT_NEAR(q.d, 0.25, 1e-12);
  EXPECT_NEAR(q.delta, 0.25, 1e-12);
  EXPECT_NEAR(q.delta_rate, 10.0, 1e-9);
}

TEST(InputDelay, BeforeTheLogTheFirstCommandHeld) {
  EffectBench bench("input_delay");
  bench.commands = {{0.7, 0.2}, {1.0, 0.1}};
  bench.now = 0.01;
  const auto q = bench.apply({0.5});
  EXPECT_EQ(q.d, 0.7);
  EXPECT_EQ(q.delta, 0.2);
  EXPECT_EQ(q.delta_rate, 0.0);
}

TEST(InputDelay, LooksBackAsFarAsItsParameterSays) {
  const EffectBench bench("input_delay");
  const double delay[] = {0.13};
  EXPECT_EQ(bench.effect().look_back(delay), 0.13);
}

TEST(InputDelay, DerivativeByTheDelayIsMinusTheSlope) {
  EffectBench bench("input_delay");
  bench.commands = {{0.0, 0.0}, {1.0, 0.1}, {0.0, 0.3}, {0.5, 0.3}};
  bench.now = 0.06;
  bench.expect_exact_derivatives({0.027});
}

TEST(SensorLatency, IsAnInputDelay) {
  EffectBench a("input_delay"), b("sensor_latency");
  for (EffectBench* one : {&a, &b}) {
    one->commands = {{0.0, 0.0}, {1.0, 0.1}, {0.0, 0.3}};
    one->now = 0.04;
  }
  EXPECT_EQ(a.apply({0.013}).delta, b.apply({0.013}).delta);
  EXPECT_EQ(a.apply({0.013}).d, b.apply({0.013}).d);
}

TEST(MotorLag, StepResponseIsAnExponential) {
  EffectBench bench("motor_lag");
  bench.memory = {0.2};
  bench.q.d = 1.0;
  const double tau = 0.08, h = 1e-4;
  for (int i = 0; i < 1000; ++i) {  // midpoint rule
    const double start = bench.memory[0];
    bench.apply({tau});
    bench.memory[0] = start + 0.5 * h * bench.memory_rate[0];
    bench.apply({tau});
    bench.memory[0] = start + h * bench.memory_rate[0];
  }
  EXPECT_NEAR(bench.memory[0], 1.0 - 0.8 * std::exp(-0.1 / tau), 1e-6);
  EXPECT_EQ(bench.apply({tau}).d, bench.memory[0]);
  EXPECT_EQ(bench.apply({tau}).delta, bench.q.delta);
  bench.expect_exact_derivatives({tau});
}

TEST(SteerLag, AngleAndRateAreThoseOfTheLag) {
  EffectBench bench("steer_lag");
  bench.memory = {0.04};
  const auto q = bench.apply({0.05});
  EXPECT_EQ(q.delta, 0.04);
  EXPECT_NEAR(q.delta_rate, (0.1 - 0.04) / 0.05, 1e-12);
  EXPECT_NEAR(bench.memory_rate[0], 1.2, 1e-12);
  EXPECT_EQ(q.d, bench.q.d);
}

TEST(Lags, StartAtTheCommandTheyFollow) {
  for (const char* id : {"motor_lag", "steer_lag"}) {
    const EffectBench bench(id);
    EXPECT_EQ(bench.start_memory({0.05})[0], id == std::string("motor_lag") ? bench.q.d : bench.q.delta);
  }
}

TEST(SteerGain, MultipliesAngleAndRate) {
  EffectBench bench("steer_gain");
  const auto q = bench.apply({0.1});
  EXPECT_NEAR(q.delta, 0.11, 1e-15);
  EXPECT_NEAR(q.delta_rate, 0.275, 1e-15);
  bench.expect_exact_derivatives({0.1});
}

TEST(SteerOffset, Adds) {
  EffectBench bench("steer_offset");
  EXPECT_NEAR(bench.apply({-0.02}).delta, 0.08, 1e-15);
  bench.expect_exact_derivatives({-0.02});
}

TEST(CommandChain, OrderIsDelayLagGainOffset) {
  int last = -1;
  for (const char* id : {"input_delay", "motor_lag", "steer_lag", "steer_gain", "steer_offset"}) {
    const EffectBench bench(id);
    EXPECT_EQ(bench.effect().stage(), Stage::command);
    EXPECT_GT(bench.entry().decl->precedence, last) << id;
    last = bench.entry().decl->precedence;
  }
}

}  // namespace test_effects_command
}  // namespace gripline
