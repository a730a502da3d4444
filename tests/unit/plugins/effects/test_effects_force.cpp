#include "support/effect_bench.hpp"

namespace gripline {
namespace {

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

TEST(Relaxation, StartsAtTheStaticForces) {
  const EffectBench bench("relaxation");
  EXPECT_EQ(bench.start_memory({0.5}), (std::vector<double>{3.0, 2.5}));
}

}  // namespace
}  // namespace gripline
