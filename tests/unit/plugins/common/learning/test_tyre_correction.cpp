#include "common/learning/tyre_correction.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gripline {
namespace test_tyre_correction {

constexpr double v_min = 2.0, mass = 1200.0, inertia = 2000.0;

/// What the nominal model says of a car with turned wheels, at a speed.
Quantities<double> nominal(double vx) {
  Quantities<double> q{};
  q.vx = vx;
  q.omega = 0.2;
  q.delta = 0.3;
  q.lf = 1.3;
  q.lr = 1.4;
  q.m = mass;
  q.Iz = inertia;
  q.load_front = q.load_rear = 1.0;
  q.ax = 1.0;
  q.ay = 0.5;
  q.aw = 0.1;
  return q;
}

Quantities<double> corrected(double vx, const Place& at = {}) {
  Quantities<double> q = nominal(vx);
  learning::correct_body(q, at, {.v_min = v_min}, [](Axle, double slip) { return 40000.0 * slip; });
  return q;
}

TEST(TyreCorrection, IsTheWholeBodyOfACarThatMoves) {
  const double vx = 3.0;
  const Quantities<double> q = corrected(vx);
  const double front = 40000.0 * (0.3 - std::atan(1.3 * 0.2 / vx)), rear = 40000.0 * std::atan(1.4 * 0.2 / vx);
  EXPECT_NEAR(q.ax, 1.0 - front * std::sin(0.3) / mass, 1e-9);
  EXPECT_NEAR(q.ay, (rear + front * std::cos(0.3)) / mass - vx * 0.2, 1e-9);
  EXPECT_NEAR(q.aw, (1.3 * front * std::cos(0.3) - 1.4 * rear) / inertia, 1e-9);
}

/// Drive that lifts the front axle leaves it no side force, and the rest as it is.
TEST(TyreCorrection, AnAxleWithoutLoadHasNoForce) {
  const learning::CorrectionTerms terms{.v_min = v_min, .ellipse = {1.5, 0.0, 0.6}, .peaks = {6000.0, 6000.0}};
  Quantities<double> q = nominal(3.0);
  q.drive_force = 3000.0;
  q.load_front = 0.0;
  learning::correct_body(q, Place{}, terms, [](Axle, double slip) { return 40000.0 * slip; });
  const double share = std::sqrt(1.0 - 1.0 / 9.0), rear = share * 40000.0 * std::atan(1.4 * 0.2 / 3.0);
  EXPECT_DOUBLE_EQ(q.ay, rear / mass - 3.0 * 0.2);
  EXPECT_DOUBLE_EQ(q.aw, -1.4 * rear / inertia);
}

/// A slippery place is a car with less load: side forces fall, and what drive may take of them is less.
TEST(TyreCorrection, ForcesAreTimesTheGripOfThePlace) {
  Place slippery;
  slippery.grip = 0.6;
  const learning::CorrectionTerms terms{.v_min = v_min, .ellipse = {1.5, 0.4, 0.6}, .peaks = {6000.0, 6000.0}};
  for (const double drive : {0.0, 3000.0}) {
    Quantities<double> here = nominal(3.0), light = nominal(3.0);
    here.drive_force = light.drive_force = drive;
    light.load_front = light.load_rear = 0.6;
    const auto force = [](Axle, double slip) { return 40000.0 * slip; };
    learning::correct_body(here, slippery, terms, force);
    learning::correct_body(light, Place{}, terms, force);
    EXPECT_EQ(here.ax, light.ax);
    EXPECT_EQ(here.ay, light.ay);
    EXPECT_EQ(here.aw, light.aw);
    EXPECT_LT(std::abs(here.aw), std::abs(corrected(3.0).aw));
  }
}

/// At rest a turned wheel pushes nothing: a controller that believes it does never drives off.
TEST(TyreCorrection, FadesTowardsStandstill) {
  const Quantities<double> rest = corrected(0.0);
  EXPECT_EQ(rest.ax, 1.0);
  EXPECT_EQ(rest.ay, 0.5);
  EXPECT_EQ(rest.aw, 0.1);
  double last = rest.ay;
  for (const double vx : {0.5, 1.0, 1.5, 2.0}) {
    const double now = corrected(vx).ay;
    EXPECT_GT(now, last) << vx;
    last = now;
  }
}

/// Forces that a correction adds to a nominal car that only rolls: along and across [N], and about the vertical [N m].
struct Added {
  double along, across, moment;
};
Added added(double vx, double vy, double omega, double delta, const learning::CorrectionTerms& terms) {
  Quantities<double> q = nominal(vx);
  q.vy = vy;
  q.omega = omega;
  q.delta = delta;
  learning::correct_body(q, Place{}, terms, [](Axle, double slip) { return 40000.0 * slip; });
  return {mass * (q.ax - 1.0 - vy * omega), mass * (q.ay + vx * omega), inertia * q.aw};
}

/// Wheels that are turned to the left push the front of a car that rolls backwards to the right.
TEST(TyreCorrection, FrontWheelsOfAReversingCarOpposeItsMotion) {
  const Added left = added(-3.0, 0.0, 0.0, 0.3, {.v_min = v_min});
  EXPECT_NEAR(left.across, -40000.0 * 0.3 * std::cos(0.3), 1e-6);
  EXPECT_NEAR(left.along, 40000.0 * 0.3 * std::sin(0.3), 1e-6);
  EXPECT_LT(left.moment, 0.0);
  const Added right = added(-3.0, 0.0, 0.0, -0.3, {.v_min = v_min});
  EXPECT_EQ(right.across, -left.across);
  EXPECT_EQ(right.moment, -left.moment);
  EXPECT_EQ(right.along, left.along);
}

TEST(TyreCorrection, TyresTakeEnergyWhicheverWayTheCarMoves) {
  for (const double vx : {-20.0, -5.0, -2.0, 2.0, 5.0, 20.0})
    for (const double vy : {-1.5, -0.2, 0.0, 0.2, 1.5})
      for (const double omega : {-0.8, 0.0, 0.1, 0.8})
        for (const double delta : {-0.4, -0.05, 0.0, 0.05, 0.4}) {
          const Added force = added(vx, vy, omega, delta, {.v_min = v_min});
          EXPECT_LE(force.along * vx + force.across * vy + force.moment * omega, 1e-6)
              << vx << " " << vy << " " << omega << " " << delta;
        }
}

TEST(TyreCorrection, ResistanceOpposesTheMotion) {
  const learning::CorrectionTerms terms{.v_min = v_min, .resistance = {100.0, 0.5}};
  EXPECT_NEAR(added(4.0, 0.0, 0.0, 0.0, terms).along, -108.0, 1e-9);
  EXPECT_NEAR(added(-4.0, 0.0, 0.0, 0.0, terms).along, 108.0, 1e-9);
}

/// A nominal car without tyres knows the grade and leaves the bank out, as its wheels hold it: so they do at rest.
TEST(TyreCorrection, ABankPullsACarThatMovesAndNoneAtRest) {
  Place sloped;
  sloped.bank = 0.04;
  sloped.grade = 0.06;
  EXPECT_EQ(corrected(0.0, sloped).bank, 0.0);
  EXPECT_NEAR(corrected(0.5 * v_min, sloped).bank, 0.02, 1e-15);
  EXPECT_EQ(corrected(v_min, sloped).bank, 0.04);
  EXPECT_EQ(corrected(-3.0, sloped).bank, 0.04);
  EXPECT_EQ(corrected(0.0, sloped).grade, 0.0);  // the nominal model's, which the bench has as 0
  EXPECT_EQ(corrected(3.0, sloped).grade, 0.0);
  Quantities<double> with_tyres = nominal(3.0);
  with_tyres.bank = 0.04;
  learning::correct_body(with_tyres, sloped, {.model_has_tyres = true, .v_min = v_min},
                         [](Axle, double slip) { return 40000.0 * slip; });
  EXPECT_EQ(with_tyres.bank, 0.04);
}

}  // namespace test_tyre_correction
}  // namespace gripline
