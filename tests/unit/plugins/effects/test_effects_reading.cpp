#include "support/effect_bench.hpp"

namespace gripline {
namespace test_effects_reading {

using test::EffectBench;

Reading<double> read(const char* id, double parameter) {
  const EffectBench bench(id);
  Reading<double> r{1, 2, 3, 4, 5, 6};
  const Place at;
  Points<double> points;
  points.n = 1;
  points.reading = &r;
  points.at = &at;
  points.params = &parameter;
  EXPECT_EQ(bench.effect().stage(), Stage::reading);
  bench.effect().apply(points);
  return r;
}

TEST(VxScale, ChangesTheSpeedAlone) {
  const auto r = read("vx_scale", 0.05);
  EXPECT_NEAR(r.vx, 4.2, 1e-14);
  EXPECT_EQ(r.x, 1);
  EXPECT_EQ(r.y, 2);
  EXPECT_EQ(r.yaw, 3);
  EXPECT_EQ(r.vy, 5);
  EXPECT_EQ(r.omega, 6);
}

TEST(VxBias, AddsToTheSpeed) { EXPECT_NEAR(read("vx_bias", -0.3).vx, 3.7, 1e-14); }

TEST(YawrateBias, AddsToTheYawRate) { EXPECT_NEAR(read("yawrate_bias", 0.02).omega, 6.02, 1e-14); }

TEST(Speed, IsScaledBeforeItIsShifted) {
  EXPECT_LT(EffectBench("vx_scale").entry().decl->precedence, EffectBench("vx_bias").entry().decl->precedence);
}

}  // namespace test_effects_reading
}  // namespace gripline
