#include <cmath>
#include <random>

#include "support/effect_bench.hpp"

namespace gripline {
namespace test_effects_body {

using test::EffectBench;

TEST(AeroDrag, GrowsWithTheSquareOfSpeed) {
  EffectBench bench("aero_drag");
  EXPECT_NEAR(bench.apply({0.5}).ax, 0.4 - 0.5 * 0.64, 1e-14);
}

TEST(RollingRes, IsConstant) {
  EffectBench bench("rolling_res");
  EXPECT_NEAR(bench.apply({0.3}).ax, 0.1, 1e-14);
}

/// A car that rolls backwards is slowed as well, and one at rest is not set moving.
TEST(Resistances, ActAgainstTheMotion) {
  for (const char* id : {"aero_drag", "rolling_res"}) {
    EffectBench bench(id);
    const double forward = bench.apply({0.5}).ax - bench.q.ax;
    bench.q.vx = -bench.q.vx;
    EXPECT_NEAR(bench.apply({0.5}).ax - bench.q.ax, -forward, 1e-14) << id;
    bench.expect_exact_derivatives({0.5});
    bench.q.vx = 0.0;
    EXPECT_EQ(bench.apply({0.5}).ax, bench.q.ax) << id;
  }
  EffectBench crawling("rolling_res");
  crawling.q.vx = -0.01;
  EXPECT_NEAR(crawling.apply({0.5}).ax - crawling.q.ax, 0.25, 1e-14);
}

TEST(DiffYaw, DampsTheYawRate) {
  EffectBench bench("diff_yaw");
  EXPECT_NEAR(bench.apply({2.0}).aw, -0.8 - 2.4, 1e-14);
}

TEST(TorqueVec, FollowsDriveForceAndSteering) {
  EffectBench bench("torque_vec");
  EXPECT_NEAR(bench.apply({0.6}).aw, -0.8 + 0.6 * (2.0 / 2.0) / 1.0 * (0.1 / 0.2), 1e-14);
}

TEST(Wind, FromBehindSlowsACarThatRollsBackwards) {
  EffectBench bench("wind");
  bench.q.yaw = 0.0;
  bench.q.vx = -4.0;
  EXPECT_NEAR(bench.apply({3.0, 0.0}).ax - bench.q.ax, 0.05 * (49.0 - 16.0) / 2.0, 1e-14);
}

TEST(Wind, ActsOnTheAirSpeedInTheCarsAxes) {
  EffectBench bench("wind");
  const double wx = 3.0, wy = -2.0, c = std::cos(0.7), s = std::sin(0.7);
  const double rx = 4.0 - (wx * c + wy * s), ry = -0.3 - (-wx * s + wy * c);
  const auto q = bench.apply({wx, wy});
  EXPECT_NEAR(q.ax, 0.4 - 0.05 * (rx * std::abs(rx) - 16.0) / 2.0, 1e-14);
  EXPECT_NEAR(q.ay, 1.6 - 2.5 * 0.05 * (ry * std::hypot(rx, ry) + 0.3 * std::hypot(4.0, -0.3)) / 2.0, 1e-14);
  bench.expect_exact_derivatives({wx, wy});
}

TEST(PlaneTilt, IsAGradeAheadAndABankAcross) {
  EffectBench bench("plane_tilt");
  const double c = std::cos(0.7), s = std::sin(0.7);
  const auto q = bench.apply({0.02, 0.01});
  EXPECT_NEAR(q.grade, 0.01 + 0.02 * c + 0.01 * s, 1e-15);
  EXPECT_NEAR(q.bank, -0.02 + 0.02 * s - 0.01 * c, 1e-15);
  bench.expect_exact_derivatives({0.02, 0.01});
}

TEST(YawResponse, GoesToTheTurnThatTheTyresBear) {
  EffectBench bench("yaw_response");
  const double no_slip = bench.q.vx * bench.q.delta / (bench.q.lf + bench.q.lr);
  for (const double mu : {0.2, 1.0, 5.0}) {
    const double omega = no_slip / std::hypot(1.0, no_slip * bench.q.vx / (mu * gravity));
    const auto q = bench.apply({0.1, mu});
    EXPECT_NEAR(q.aw, (omega - bench.q.omega) / 0.1, 1e-12);
    EXPECT_NEAR(q.ay, (bench.q.lr * omega - bench.q.vy) / 0.1, 1e-12);
    EXPECT_LT(std::abs(omega * bench.q.vx), mu * gravity);
    bench.expect_exact_derivatives({0.1, mu});
  }
}

/// Ten coefficients without mean.
std::vector<double> profile() {
  std::mt19937_64 random(7);
  std::vector<double> c(10);
  double mean = 0.0;
  for (double& x : c) {
    x = static_cast<double>(random() % 1000) * 1e-5;
    mean += 0.1 * x;
  }
  for (double& x : c) x -= mean;
  return c;
}

TEST(LapSlopes, AreTheCubicSplineOfTheirCoefficients) {
  const std::vector<double> c = profile();
  for (const char* id : {"grade", "bank"}) {
    EffectBench bench(id);
    bench.at.direction = 1.0;
    bench.at.lap_fraction = 0.4;  // on a knot: (c3 + 4 c4 + c5) / 6
    const auto q = bench.apply(c);
    const double slope = (c[3] + 4.0 * c[4] + c[5]) / 6.0;
    const bool grade = id == std::string("grade");
    EXPECT_NEAR(grade ? q.grade : q.bank, (grade ? 0.01 : -0.02) + slope, 1e-15);
    bench.at.lap_fraction = 0.95;  // between the last knot and the first
    const auto wrapped = bench.apply(c);
    const double half = (c[8] + 23.0 * c[9] + 23.0 * c[0] + c[1]) / 48.0;
    EXPECT_NEAR(grade ? wrapped.grade : wrapped.bank, (grade ? 0.01 : -0.02) + half, 1e-15);
    bench.expect_exact_derivatives(c);
  }
}

TEST(LapSlopes, TurnRoundWithTheDirection) {
  const std::vector<double> c = profile();
  EffectBench bench("bank");
  bench.at.lap_fraction = 0.13;
  bench.at.direction = 1.0;
  const double along = bench.apply(c).bank + 0.02;
  bench.at.direction = -1.0;
  EXPECT_NEAR(bench.apply(c).bank + 0.02, -along, 1e-15);
}

TEST(Grade, HasNoMean) {
  EffectBench bench("grade");
  bench.at.lap_fraction = 0.37;
  const double zero = bench.apply(std::vector<double>(10, 0.0)).grade;
  EXPECT_NEAR(bench.apply(std::vector<double>(10, 0.05)).grade, zero, 1e-15);
}

TEST(BodyEffects, DerivativesAreExact) {
  for (const char* id : {"aero_drag", "rolling_res", "diff_yaw", "torque_vec"})
    EffectBench(id).expect_exact_derivatives({0.4});
}

}  // namespace test_effects_body
}  // namespace gripline
