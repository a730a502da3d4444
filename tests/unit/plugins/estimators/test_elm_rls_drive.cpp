// What elm_rls learns under drive and brakes: how far samples teach of tyres then, and what it
// learns of the drive itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/learning_rig.hpp"

namespace gripline {
namespace test_elm_rls_drive {

using namespace rig;

double fresh(double) { return 1.0; }

TEST(ElmRls, SamplesUnderDriveTeachNothingOfTheTyresWhereTold) {
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal, {{"most_drive", 0.0}});
  Drive drive = drive_bends(6, 3, fresh);
  learn(*rls, nominal, drive);
  EXPECT_NEAR(rls->belief().mu_front, 1.0, 1e-9);
  EXPECT_NEAR(rls->belief().mu_rear, 1.0, 1e-9);
  EXPECT_GT(rls->belief().sigma_front, 0.2);
}

/// The true car's way through a slalom, begun at `speed`, with the wheels turned by up to `angle`; `pedal` and `factor`
/// of step i.
template <class Pedal, class Factor>
Drive slalom(int steps, double speed, double angle, const Pedal& pedal, const Factor& factor, TrueCar car = {}) {
  Drive drive;
  State x;
  x.vx = speed;
  drive.x.push_back(x);
  for (int i = 0; i < steps; ++i) {
    car.factor = factor(i);
    drive.u.push_back({pedal(i), (angle * std::sin(8.0 * i * dt) - x.delta) / dt});
    x = car.step(x, drive.u.back());
    drive.x.push_back(x);
    drive.factor.push_back(car.factor);
  }
  return drive;
}

/// What 1.2 s of a slalom teach at one position of the pedal, where any drive is too much (`most_drive`), if friction
/// is 0.91 in place of the expected 1.0. This car's brakes are weak: even an ellipse of 0.3 takes two per cent off the
/// side forces that the true car has.
Belief learned_at_pedal(double d, double sharing_spread, double angle = 0.3) {
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal,
                                  {{"most_drive", 0.0},
                                   {"sharing_spread", sharing_spread},
                                   {"ellipse", 0.3},
                                   {"drive_front", 0.5},
                                   {"brake_front", 0.5}});
  learn(*rls, nominal,
        slalom(
            60, 3.5, angle, [d](int) { return d; }, [](int) { return 1.0; }));
  return rls->belief();
}

TEST(ElmRls, BrakingTeachesAsFarAsTheSharingOfFrictionIsKnown) {
  const TrueCar truth;
  const Belief untold = learned_at_pedal(-0.1, 0.0), told = learned_at_pedal(-0.1, 1.0);
  const Belief unsure = learned_at_pedal(-0.1, 50.0), driven = learned_at_pedal(0.5, 1.0);
  EXPECT_NEAR(total_mu(untold, truth.car), 1.0, 1e-9);
  EXPECT_NEAR(total_mu(driven, truth.car), 1.0, 1e-9);
  EXPECT_NEAR(total_mu(told, truth.car), truth.mu(), 0.05);
  EXPECT_LT(told.sigma_front, 0.5 * untold.sigma_front);
  EXPECT_GT(unsure.sigma_front, 1.2 * told.sigma_front);
}

// Of a car that brakes hard and hardly turns, what brakes leave of small side forces would pass for the tyres'
// friction.
TEST(ElmRls, BrakingStraightAheadTeachesNothingOfTheTyres) {
  const Belief straight = learned_at_pedal(-0.1, 1.0, 0.02);
  EXPECT_NEAR(straight.mu_front, 1.0, 1e-9);
  EXPECT_NEAR(straight.mu_rear, 1.0, 1e-9);
}

/// What is believed after a slalom under little drive, which teaches, and some steps of another under much, which does
/// not: there friction is `factor` of what it was.
Belief belief_after_drive(double factor, int driven, double sharing_lasts) {
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal,
                                  {{"most_drive", 0.15},
                                   {"sigma_v", 0.002},
                                   {"sigma_omega", 0.005},
                                   {"sharing_spread", 1.0},
                                   {"sharing_lasts", sharing_lasts},
                                   {"ellipse", 1.0},
                                   {"drive_front", 0.5},
                                   {"brake_front", 0.5}});
  constexpr int taught = 80;  // steps
  learn(*rls, nominal,
        slalom(
            taught + driven, 2.5, 0.2, [](int i) { return i < taught ? 0.3 : 0.6; },
            [factor](int i) { return i < taught ? 1.0 : factor; }));
  return rls->belief();
}
double believed_after_drive(double factor, int driven = 30, double sharing_lasts = 1) {
  return total_mu(belief_after_drive(factor, driven, sharing_lasts), TrueCar().car);
}

TEST(ElmRls, ADropUnderDriveIsNoticed) {
  const double before = believed_after_drive(1.0, 0), kept = believed_after_drive(1.0),
               fell = believed_after_drive(0.7);
  EXPECT_NEAR(kept, before, 0.01 * before);
  EXPECT_LT(fell, 0.85 * before);
  EXPECT_GT(fell, 0.6 * before);
}

// What the tyres' share is then is known no better than before, and a drift goes on.
TEST(ElmRls, DriveTeachesOfTyresForHalfASecondAfterADrop) {
  const auto sigma = [](int driven) { return belief_after_drive(0.7, driven, 1).sigma_front; };
  EXPECT_LT(sigma(29), 0.9 * sigma(17));  // it is noticed after 16 steps
  EXPECT_GT(sigma(76), sigma(44));
}

TEST(ElmRls, ADropUnderDriveIsNoticedWhereTheSharingErrsForLong) {
  const double before = believed_after_drive(1.0, 0, 9), fell = believed_after_drive(0.7, 30, 9);
  EXPECT_LT(fell, 0.85 * before);
  EXPECT_GT(fell, 0.6 * before);
}

/// Mean relative error of the learned side forces at a visited slip, of a car whose tyres lose nothing to drive, behind
/// an ellipse that says they do, after a slalom half of which is driven.
double force_error(double sharing_lasts) {
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal,
                                  {{"sharing_spread", 1.0},
                                   {"sharing_lasts", sharing_lasts},
                                   {"ellipse", 0.4},
                                   {"drive_front", 0.5},
                                   {"brake_front", 0.5}});
  learn(*rls, nominal,
        slalom(
            400, 2.0, 0.25, [](int i) { return i % 50 < 25 ? 0.25 : 0.0; }, [](int) { return 1.0; }));
  const TrueCar truth;
  double sum = 0;
  for (const Axle axle : {Axle::front, Axle::rear}) {
    const double slip = 0.15;
    double force = 0, sigma = 0;
    EXPECT_TRUE(rls->tyre_force(axle, {&slip, 1}, {&force, 1}, {&sigma, 1}));
    sum += force / truth.force(axle, slip) - 1.0;
  }
  return 0.5 * sum;
}

TEST(ElmRls, AWrongSharingThatLastsTeachesLittleOfTheTyres) {
  const double averaged = force_error(1.0), lasting = force_error(25.0);
  EXPECT_GT(averaged, 0.025);
  EXPECT_LT(std::abs(lasting), 0.75 * averaged);
}

/// Largest error of vx' straight ahead, with full throttle to full brake, of the 1:43 car behind a nominal model that
/// is told `share` of its motor and brakes.
double straight_error(double spread, double share) {
  const TrueCar truth;
  Nominal told("ekinematic", {{"Cm1", share * truth.Cm1}, {"Cm2", share * truth.Cm2}});
  const auto rls = make_estimator("elm_rls", told, {{"drive_spread", spread}, {"brake_spread", spread}});
  learn(*rls, told, drive_bends(20, 3, fresh));
  CorrectedModel model = corrected(told, *rls);
  double largest = 0;
  for (const double vx : {1.0, 2.0})
    for (const double d : {-0.1, 0.3, 1.0}) {
      State straight;
      straight.vx = vx;
      largest = std::max(largest, std::abs(model.rates(straight, {d, 0.0}, {}).vx - truth.rates(straight, d).vx));
    }
  return largest;
}

TEST(ElmRls, LearnsByHowMuchDriveAndBrakesDifferFromWhatItWasTold) {
  for (const double share : {0.85, 1.15}) {
    const double unlearned = straight_error(0.0, share), learned = straight_error(0.1, share);
    EXPECT_GT(unlearned, 0.3);
    EXPECT_LT(learned, 0.25 * unlearned) << share << ": " << learned << " of " << unlearned;
  }
  EXPECT_LT(straight_error(0.1, 1.0), 0.05);
}

/// What is learned of a car that drive turns at 8 mm: relative errors of the side forces at a visited slip, and the
/// error of omega' in a driven turn [rad/s2].
struct ArmErrors {
  double front = 0, rear = 0, turning = 0;
};
ArmErrors arm_errors(double spread) {
  TrueCar truth;
  truth.arm = 8e-3;
  Nominal nominal("ekinematic");
  const auto rls = make_estimator("elm_rls", nominal, {{"arm_spread", spread}});
  learn(*rls, nominal,
        slalom(
            300, 2.0, 0.25, [](int i) { return i % 50 < 35 ? 0.5 : 0.0; }, [](int) { return 1.0; }, truth));
  const auto force_error = [&](Axle axle) {
    const double slip = 0.15;
    double force = 0, sigma = 0;
    EXPECT_TRUE(rls->tyre_force(axle, {&slip, 1}, {&force, 1}, {&sigma, 1}));
    return force / truth.force(axle, slip) - 1.0;
  };
  State turn;
  turn.vx = 2.0;
  turn.omega = 3.0;
  turn.delta = 0.15;
  CorrectedModel model = corrected(nominal, *rls);
  return {force_error(Axle::front), force_error(Axle::rear),
          model.rates(turn, {0.5, 0.0}, {}).omega - truth.rates(turn, 0.5).omega};
}

TEST(ElmRls, LearnsTheArmAtWhichDriveTurnsTheCar) {
  const ArmErrors unlearned = arm_errors(0.0), learned = arm_errors(0.01);
  EXPECT_LT(unlearned.turning, -2.0);
  EXPECT_LT(std::abs(learned.turning), 0.1 * std::abs(unlearned.turning));
  // Unlearned, what turns the car passes for grip of the front tyres, and for a lack of it at the rear.
  EXPECT_GT(unlearned.front, 0.02);
  EXPECT_LT(unlearned.rear, -0.01);
  EXPECT_LT(std::abs(learned.front), 0.005);
  EXPECT_LT(std::abs(learned.rear), 0.005);
}

}  // namespace test_elm_rls_drive
}  // namespace gripline
