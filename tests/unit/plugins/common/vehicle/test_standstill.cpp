#include "common/vehicle/standstill.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace gripline::vehicle {
namespace test_standstill {

/// A car of 2 kg whose brakes give up to 10 N.
template <class T = double>
Quantities<T> car(double vx, double d) {
  Quantities<T> q{};
  q.vx = T(vx), q.d = T(d), q.brake = T(10), q.motor = T(6), q.emf = T(1), q.rolling = T(0.5), q.drag = T(0.1);
  q.lf = T(0.4), q.lr = T(0.6);
  return q;
}
double force(double vx, double d, double grade = 0) { return drive_force(car(vx, d), 2.0, grade); }

TEST(Standstill, BrakesOpposeTheMotionEitherWay) {
  EXPECT_EQ(force(3, -0.5), -5.0);
  EXPECT_EQ(force(-3, -0.5), 5.0);
  EXPECT_EQ(force(0, -1), 0.0);
  for (double vx = -0.5; vx < 0.5; vx += 0.01) {
    EXPECT_LE(force(vx, -1) * vx, 0.0) << vx;
    EXPECT_NEAR(force(-vx, -1), -force(vx, -1), 1e-14) << vx;
  }
}

TEST(Standstill, TheMotorDrivesForwardAsPublished) {
  for (const double vx : {-2.0, 0.0, 2.0}) EXPECT_EQ(force(vx, 0.5), (6 - vx) * 0.5);
}

TEST(Standstill, BrakesHoldAgainstASlopeUpToTheirStrength) {
  const double pull = 2.0 * gravity * std::sin(0.1);  // 1.96 N downhill, backwards
  EXPECT_NEAR(force(0, -1, 0.1), pull, 1e-14);
  EXPECT_NEAR(force(0, -1, -0.1), -pull, 1e-14);
  EXPECT_EQ(force(0, -0.1, 0.1), 1.0);  // too weak: the car rolls back against 1 N
  EXPECT_NEAR(force(0.01, -1, 0.1), pull * (1 - 0.01 / weak_brake_speed) - 2.0 * largest_hold_rate * 0.01, 1e-14);
  EXPECT_EQ(force(weak_brake_speed, -1e-3, 0.1), -0.01);  // uphill at a walk weak brakes brake, they do not push
}

TEST(Standstill, ForcesAreContinuousInSpeedAndBrake) {
  for (const double d : {-1.0, -0.2, -1e-9})
    for (int i = -300; i <= 300; ++i) {
      const double below = 1e-3 * i - 1e-9, above = 1e-3 * i + 1e-9;
      EXPECT_NEAR(force(above, d, 0.05), force(below, d, 0.05), 1e-6);
      EXPECT_NEAR(resistance(car(above, d)), resistance(car(below, d)), 1e-6);
    }
  EXPECT_NEAR(force(0.01, -1e-12, 0.05), 0.0, 1e-10);
}

TEST(Standstill, ResistanceTurnsRoundWithTheMotion) {
  EXPECT_EQ(resistance(car(3, 0)), 0.5 + 0.9);
  EXPECT_EQ(resistance(car(-3, 0)), -1.4);
  EXPECT_EQ(resistance(car(0, 0)), 0.0);
  EXPECT_NEAR(resistance(car(-0.5 * crawl_speed, 0)), -0.25, 1e-4);
}

TEST(Standstill, AMotorThatBrakesNeverDrives) {
  EXPECT_EQ(motor_brake(6.0, 1.0, 2.0), 4.0);
  EXPECT_EQ(motor_brake(6.0, 1.0, -2.0), 4.0);
  EXPECT_EQ(motor_brake(6.0, 1.0, 7.0), 0.0);
}

/// A wheel that rolls where it points has no slip, whichever way it rolls.
TEST(Standstill, SlipVanishesWhereWheelsRollWhereTheyPoint) {
  for (const double vx : {3.0, 0.02, 0.013, 1e-9, 0.0, -1e-9, -0.013, -0.02, -3.0})
    for (const double delta : {-0.6, 0.0, 0.3}) {
      Quantities<double> q = car(vx, 0);
      q.delta = delta;
      q.omega = vx * std::tan(delta) / (q.lf + q.lr);
      q.vy = q.lr * q.omega;
      fill_slips(q);
      EXPECT_NEAR(q.slip_front, 0.0, 1e-14) << vx << ' ' << delta;
      EXPECT_NEAR(q.slip_rear, 0.0, 1e-14) << vx << ' ' << delta;
    }
}

/// Slips push against the velocity that the axles have across their wheels: the force takes energy, never gives any.
TEST(Standstill, SlipIsAgainstTheVelocityAcrossTheWheels) {
  for (const double vx : {3.0, 0.015, 0.0, -0.004, -0.02, -2.0})
    for (const double vy : {-2.0, -0.01, 0.0, 0.003, 1.0})
      for (const double omega : {-4.0, 0.0, 0.01})
        for (const double delta : {-0.5, 0.0, 0.35}) {
          Quantities<double> q = car(vx, 0);
          q.vy = vy, q.omega = omega, q.delta = delta;
          fill_slips(q);
          const double across = (vy + q.lf * omega) * std::cos(delta) - vx * std::sin(delta);
          EXPECT_LE(q.slip_front * across, 1e-16);
          EXPECT_LE(q.slip_rear * (vy - q.lr * omega), 1e-16);
          EXPECT_LT(std::abs(q.slip_front), std::numbers::pi);
        }
}

TEST(Standstill, DrivingForwardItIsTheSlipOfTheSdk) {
  Quantities<double> q = car(0.02, 0);
  q.vy = -0.1, q.omega = 0.7, q.delta = 0.2;
  fill_slips(q);
  EXPECT_EQ(q.slip_front, front_slip(0.02, q.vy, q.omega, q.delta, q.lf));
  EXPECT_EQ(q.slip_rear, rear_slip(0.02, q.vy, q.omega, q.lr));
}

TEST(Standstill, DerivativesAtRestAreFiniteAndThoseOfTheFormulas) {
  for (const double vx : {0.0, 0.01, -0.01}) {
    Quantities<Dual8> q = car<Dual8>(vx, -0.5);
    q.vx.d[0] = 1, q.vy.d[1] = 1, q.omega.d[2] = 1, q.delta.d[3] = 1, q.d.d[4] = 1;
    fill_slips(q);
    EXPECT_NEAR(q.slip_front.d[1], -1 / crawl_speed, 1e-9);
    EXPECT_NEAR(q.slip_front.d[2], -0.4 / crawl_speed, 1e-9);
    EXPECT_NEAR(q.slip_front.d[3], vx / crawl_speed, 1e-9);
    EXPECT_NEAR(q.slip_rear.d[2], 0.6 / crawl_speed, 1e-9);
    EXPECT_NEAR(drive_force(q, Dual8(2.0), 0.0).d[0], -5.0 / weak_brake_speed, 1e-9);  // 31 / s: below hold
    q.d = Dual8(-1);
    EXPECT_NEAR(drive_force(q, Dual8(2.0), 0.0).d[0], -2.0 * largest_hold_rate, 1e-9);
    EXPECT_NEAR(resistance(q).d[0], 0.5 / crawl_speed + 0.3 * vx * vx / crawl_speed, 1e-9);
    for (const double one : q.slip_front.d) EXPECT_TRUE(std::isfinite(one));
  }
}

}  // namespace test_standstill
}  // namespace gripline::vehicle
