#include "support/effect_bench.hpp"

namespace gripline {
namespace test_effects_force {

using test::EffectBench;

TEST(Relaxation, ForcesFollowTheStaticOnesOverADistance) {
  EffectBench bench("relaxation");
  bench.memory = {1.0, 2.0};
  const auto q = bench.apply({0.5});
  EXPECT_EQ(q.force_front, 1.0);
  EXPECT_EQ(q.force_rear, 2.0);
  EXPECT_NEAR(bench.memory_rate[0], (4.0 / 0.5) * (3.0 - 1.0), 1e-13);
  EXPECT_NEAR(bench.memory_rate[1], (4.0 / 0.5) * (2.5 - 2.0), 1e-13);
}

/// What counts is the way that the tyres roll: signed, forces would run away from the static ones.
TEST(Relaxation, ForcesFollowTheStaticOnesBackwardsToo) {
  EffectBench bench("relaxation");
  bench.memory = {1.0, 2.0};
  bench.q.vx = -4.0;
  bench.apply({0.5});
  EXPECT_NEAR(bench.memory_rate[0], (4.0 / 0.5) * (3.0 - 1.0), 1e-13);
  EXPECT_NEAR(bench.memory_rate[1], (4.0 / 0.5) * (2.5 - 2.0), 1e-13);
}

/// The force of a moment ago fades as an axle slides across, else it would push a car that does not roll for ever.
TEST(Relaxation, ForcesFollowWhereAnAxleSlidesAcross) {
  EffectBench bench("relaxation");
  bench.memory = {1.0, 2.0};
  bench.q.vx = 0.0, bench.q.vy = 3.0, bench.q.omega = -2.0;
  bench.apply({0.5});
  EXPECT_NEAR(bench.memory_rate[0], ((3.0 - 0.4 * 2.0) / 0.5) * (3.0 - 1.0), 1e-13);
  EXPECT_NEAR(bench.memory_rate[1], ((3.0 + 0.6 * 2.0) / 0.5) * (2.5 - 2.0), 1e-13);
  bench.q.vx = 2.5;  // the front rolls more than it slides, the rear does not
  bench.apply({0.5});
  EXPECT_NEAR(bench.memory_rate[0], (2.5 / 0.5) * (3.0 - 1.0), 1e-13);
  EXPECT_NEAR(bench.memory_rate[1], (4.2 / 0.5) * (2.5 - 2.0), 1e-13);
}

TEST(Relaxation, StartsAtTheStaticForces) {
  const EffectBench bench("relaxation");
  EXPECT_EQ(bench.start_memory({0.5}), (std::vector<double>{3.0, 2.5}));
}

}  // namespace test_effects_force
}  // namespace gripline
