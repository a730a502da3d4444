#include <cmath>
#include <numbers>

#include "support/effect_bench.hpp"

namespace gripline {
namespace test_effects_frames {

using test::EffectBench;

template <class T>
Reading<T> read(const char* id, const std::vector<T>& params, Reading<T> r) {
  const EffectBench bench(id);
  const Place at;
  Points<T> points;
  points.n = 1;
  points.reading = &r;
  points.at = &at;
  points.params = params.data();
  EXPECT_EQ(bench.effect().stage(), Stage::reading);
  bench.effect().apply(points);
  return r;
}

/// A car at (1, 2) that heads along +y, slides and turns.
const Reading<double> turning{1, 2, std::numbers::pi / 2, 4, 0.5, 1.5};

TEST(PoseLever, ShowsAPointAheadAndToTheLeft) {
  const auto r = read<double>("pose_lever", {0.3, 0.1}, turning);
  EXPECT_NEAR(r.x, 1.0 - 0.1, 1e-14);
  EXPECT_NEAR(r.y, 2.0 + 0.3, 1e-14);
  EXPECT_EQ(r.yaw, turning.yaw);
  EXPECT_EQ(r.vx, turning.vx);
}

TEST(PoseYaw, TurnsTheHeadingAlone) {
  const auto r = read<double>("pose_yaw", {0.02}, turning);
  EXPECT_NEAR(r.yaw, turning.yaw + 0.02, 1e-14);
  EXPECT_EQ(r.x, turning.x);
  EXPECT_EQ(r.vy, turning.vy);
}

TEST(VelocityLever, ShowsTheVelocityOfAPointOfARigidBody) {
  const auto r = read<double>("velocity_lever", {0.3, 0.1}, turning);
  EXPECT_NEAR(r.vx, 4.0 - 0.1 * 1.5, 1e-14);
  EXPECT_NEAR(r.vy, 0.5 + 0.3 * 1.5, 1e-14);
  EXPECT_EQ(r.omega, turning.omega);
}

TEST(VelocityYaw, KeepsTheSpeedAndTurnsItsAxes) {
  const auto r = read<double>("velocity_yaw", {std::numbers::pi / 2}, turning);
  EXPECT_NEAR(r.vx, 0.5, 1e-14);  // axes turned to the left: what went left now goes ahead
  EXPECT_NEAR(r.vy, -4.0, 1e-14);
  const auto small = read<double>("velocity_yaw", {0.01}, turning);
  EXPECT_NEAR(std::hypot(small.vx, small.vy), std::hypot(4.0, 0.5), 1e-14);
}

TEST(Frames, ReadingsOfALeverAgreeWithItsPath) {
  // The velocity of the pose's point, turned into the world, is the rate of the pose's point.
  const double dt = 1e-6;
  Reading<double> later = turning;
  const double c = std::cos(turning.yaw), s = std::sin(turning.yaw);
  later.x += dt * (turning.vx * c - turning.vy * s);
  later.y += dt * (turning.vx * s + turning.vy * c);
  later.yaw += dt * turning.omega;
  const auto a = read<double>("pose_lever", {0.3, -0.2}, turning), b = read<double>("pose_lever", {0.3, -0.2}, later);
  const auto v = read<double>("velocity_lever", {0.3, -0.2}, turning);
  EXPECT_NEAR((b.x - a.x) / dt, v.vx * c - v.vy * s, 1e-5);
  EXPECT_NEAR((b.y - a.y) / dt, v.vx * s + v.vy * c, 1e-5);
}

TEST(Frames, DerivativesAreExact) {
  for (const auto& [id, params] : {std::pair("pose_lever", std::vector<double>{0.3, -0.2}),
                                   {"pose_yaw", {0.1}},
                                   {"velocity_lever", {0.3, -0.2}},
                                   {"velocity_yaw", {0.1}}})
    for (std::size_t p = 0; p < params.size(); ++p) {
      std::vector<Dual8> seeded(params.begin(), params.end());
      seeded[p].d[0] = 1.0;
      const auto d = read<Dual8>(id, seeded, {1, 2, turning.yaw, 4, 0.5, 1.5});
      std::vector<double> up = params, down = params;
      up[p] += 1e-6;
      down[p] -= 1e-6;
      const auto high = read<double>(id, up, turning), low = read<double>(id, down, turning);
      for (const auto& [slope, h, l] : {std::tuple(d.x.d[0], high.x, low.x),
                                        {d.y.d[0], high.y, low.y},
                                        {d.yaw.d[0], high.yaw, low.yaw},
                                        {d.vx.d[0], high.vx, low.vx},
                                        {d.vy.d[0], high.vy, low.vy}})
        EXPECT_NEAR(slope, (h - l) / 2e-6, 1e-8) << id << ", parameter " << p;
    }
}

TEST(Frames, LeversActBeforeTurns) {
  EXPECT_LT(EffectBench("pose_lever").entry().decl->precedence, EffectBench("pose_yaw").entry().decl->precedence);
  EXPECT_LT(EffectBench("velocity_lever").entry().decl->precedence,
            EffectBench("velocity_yaw").entry().decl->precedence);
}

}  // namespace test_effects_frames
}  // namespace gripline
