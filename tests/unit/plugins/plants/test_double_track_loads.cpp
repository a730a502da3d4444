// Tyres and wheel loads of the full-size car against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/double_track_rig.hpp"

namespace gripline::double_track {
namespace test_double_track_loads {

TEST(Tyre, PeaksAndSlopes) {
  const Params p;
  const DoubleTrackCar car(p);
  for (const Axle axle : {Axle::front, Axle::rear}) {
    const Tyre& tyre = car.tyre(axle);
    const double Fz = tyre.static_load();
    double peak = 0.0;
    double at = 0.0;
    for (double slip = 0.0; slip < 1.0; slip += 1e-4)
      if (tyre.lateral(Fz, slip) > peak) peak = tyre.lateral(Fz, at = slip);
    EXPECT_NEAR(peak / Fz, 1.05, 1e-6);
    EXPECT_GT(at, 0.08);  // 5 to 12 degrees, as real tyres
    EXPECT_LT(at, 0.20);
    const double stiffness = axle == Axle::front ? p.stiffness_front : p.stiffness_rear;
    EXPECT_NEAR(tyre.lateral(Fz, 1e-5) / 1e-5 / Fz, stiffness, 1e-3 * stiffness);
    EXPECT_NEAR(tyre.lateral(Fz, -0.07), -tyre.lateral(Fz, 0.07), 1e-9);
    // load: a tyre at twice its load has a smaller coefficient and less than twice the stiffness
    EXPECT_NEAR(tyre.mu(p.mu_y, 2.0 * Fz), p.mu_y * (1.0 - p.load_sensitivity), 1e-12);
    EXPECT_LT(tyre.cornering(2.0 * Fz), tyre.cornering(Fz));
  }
}

TEST(Tyre, CombinedSlipPeaksLieOnAnEllipse) {
  const Params p;
  const DoubleTrackCar car(p);
  const Tyre& tyre = car.tyre(Axle::front);
  const double Fz = tyre.static_load();
  const WheelMotion fast{30.0, 0.0, 30.0};
  for (const double direction : {0.0, 0.3, 0.7, 1.1, 1.5}) {
    double outermost = 0.0;
    for (double s = 0.0; s < 0.5; s += 1e-3) {
      const TyreForce f = tyre.force(fast, s * std::cos(direction), s * std::sin(direction), Fz, 0.8, 1e-3);
      outermost = std::max(outermost, std::hypot(f.x / (0.8 * p.mu_x * Fz), f.y / (0.8 * p.mu_y * Fz)));
      EXPECT_GE(f.x * std::cos(direction) + f.y * std::sin(direction), 0.0);
    }
    EXPECT_NEAR(outermost, 1.0, 1e-4) << direction;
  }
}

TEST(Tyre, RelaxesOverItsLengths) {
  const Params p;
  const DoubleTrackCar car(p);
  const Tyre& tyre = car.tyre(Axle::rear);
  const double V = 10.0;
  const double slip = 0.005;
  const double h = 1e-5;
  double y = 0.0;
  for (double way = 0.0; way < p.relaxation_y; way += V * h)
    y += h * tyre.force({V, -slip * V, V}, 0.0, y, tyre.static_load(), 1.0, h).rate_y;
  EXPECT_NEAR(y / slip, 1.0 - std::exp(-1.0), 0.01);
  double x = 0.0;
  for (double way = 0.0; way < p.relaxation_x; way += V * h)
    x += h * tyre.force({V, 0.0, (1.0 - slip) * V}, x, 0.0, tyre.static_load(), 1.0, h).rate_x;
  EXPECT_NEAR(x / -slip, 1.0 - std::exp(-1.0), 0.01);
}

TEST(Tyre, TruthAddsUpToTheStatedFriction) {
  const Params p;
  const DoubleTrackCar car(p);
  double sum = 0.0;
  for (const Axle axle : {Axle::front, Axle::rear}) {
    const Tyre& tyre = car.tyre(axle);
    double peak = 0.0;
    for (double slip = 0.0; slip < 0.5; slip += 1e-4)
      peak = std::max(peak, 2.0 * tyre.lateral(tyre.static_load(), slip));
    sum += peak;
  }
  EXPECT_NEAR(sum / (p.m * gravity), 1.05, 1e-6);
}

TEST(Loads, StandingOnASlope) {
  const Params p;
  DoubleTrackCar car(p);
  Road road;
  road.grade = 0.08;
  road.bank = 0.05;
  car.reset({}, road);
  drive(car, -1.0, 0.0, 10.0, road);
  const auto& w = car.loads();
  const double wheelbase = p.lf + p.lr;
  const double weight =
      p.m * gravity * std::sqrt(1.0 - std::pow(std::sin(road.grade), 2) - std::pow(std::sin(road.bank), 2));
  const double along = p.m * gravity * std::sin(road.grade);
  const double across = p.m * gravity * std::sin(road.bank);
  EXPECT_NEAR(w[0].Fz + w[1].Fz, (weight * p.lr - along * p.h) / wheelbase, 1e-3);
  EXPECT_NEAR(w[2].Fz + w[3].Fz, (weight * p.lf + along * p.h) / wheelbase, 1e-3);
  // the right side is higher: the left wheels carry more
  const double moment = 0.5 * (w[0].Fz - w[1].Fz) * p.track_front + 0.5 * (w[2].Fz - w[3].Fz) * p.track_rear;
  EXPECT_NEAR(moment, across * p.h, 1e-3);
  double Fx = 0.0;
  double Fy = 0.0;
  for (const WheelLoads& wheel : w) {
    Fx += wheel.Fx;
    Fy += wheel.Fy;
  }
  EXPECT_NEAR(Fx, along, 1e-3);
  EXPECT_NEAR(Fy, -across, 1e-3);
}

TEST(Loads, BrakingAndCorneringMoveThem) {
  Params p = bare();
  DoubleTrackCar car(p);
  const Road road;
  car.reset(rolling(40.0), road);
  drive(car, -0.6, 0.0, 2.0, road);
  double Fx = 0.0;
  for (const WheelLoads& w : car.loads()) Fx += w.Fx;
  const double wheelbase = p.lf + p.lr;
  EXPECT_NEAR(car.loads()[0].Fz + car.loads()[1].Fz, (p.m * gravity * p.lr - Fx * p.h) / wheelbase, 1.0);

  settle_on_circle(car, 20.0, 80.0, road);
  const auto& w = car.loads();
  const double ay = car.motion().vx * car.motion().omega;
  const double moment = 0.5 * (w[1].Fz - w[0].Fz) * p.track_front + 0.5 * (w[3].Fz - w[2].Fz) * p.track_rear;
  EXPECT_NEAR(moment, p.m * ay * p.h, 0.003 * p.m * ay * p.h);
}

TEST(Loads, DownforceAndDips) {
  Params p = bare();
  p.downforce_front = 0.2;
  p.downforce_rear = 0.3;
  DoubleTrackCar car(p);
  struct Valley final : Ground {
    Patch at(double x, double, double) const override { return {0.001 * x, 0.0, 1.0}; }
  };
  const Valley valley;
  car.reset(rolling(30.0), valley);
  double sum = 0.0;
  for (const WheelLoads& w : car.loads()) sum += w.Fz;
  EXPECT_NEAR(sum, p.m * (gravity + 900.0 * 0.001) + 0.5 * 900.0, 1.0);
}

TEST(Loads, DownforceActsOnItsAxle) {
  Params p = bare();
  p.downforce_front = 0.2;
  p.downforce_rear = 0.5;
  DoubleTrackCar car(p);
  car.reset(rolling(40.0), Road{});
  const auto& w = car.loads();
  EXPECT_NEAR(w[0].Fz + w[1].Fz, p.m * gravity * p.lr / (p.lf + p.lr) + 0.2 * 1600.0, 1.0);
  EXPECT_NEAR(w[2].Fz + w[3].Fz, p.m * gravity * p.lf / (p.lf + p.lr) + 0.5 * 1600.0, 1.0);
}

TEST(Loads, LiftUnloads) {
  Params p = bare();
  p.downforce_front = -0.6;
  p.downforce_rear = -0.2;
  DoubleTrackCar car(p);
  const auto sum = [&](double speed) {
    car.reset(rolling(speed), Road{});
    double all = 0.0;
    for (const WheelLoads& w : car.loads()) {
      EXPECT_GE(w.Fz, 0.0);
      all += w.Fz;
    }
    return all;
  };
  EXPECT_NEAR(sum(40.0), p.m * gravity - 0.8 * 1600.0, 1.0);
  EXPECT_NEAR(car.loads()[0].Fz + car.loads()[1].Fz, p.m * gravity * p.lr / (p.lf + p.lr) - 0.6 * 1600.0, 1.0);
  EXPECT_EQ(sum(200.0), 0.0);  // it flies
}

TEST(Loads, RollStiffnessSharesTheTransfer) {
  Params p = bare();
  p.roll_front = 0.7;
  DoubleTrackCar car(p);
  const Road road;
  settle_on_circle(car, 15.0, 60.0, road);
  const auto& w = car.loads();
  // side forces of the axles as the moments balance; the steering angle turns them by a few hundredths only
  const double side = p.m * car.motion().vx * car.motion().omega;
  const double front = side * p.lr / (p.lf + p.lr);
  const double rear = side - front;
  const double elastic = (p.h - p.roll_centre_front) * front + (p.h - p.roll_centre_rear) * rear;
  const double moved_front = (p.roll_centre_front * front + 0.7 * elastic) / p.track_front;
  const double moved_rear = (p.roll_centre_rear * rear + 0.3 * elastic) / p.track_rear;
  EXPECT_NEAR(0.5 * (w[1].Fz - w[0].Fz), moved_front, 0.01 * moved_front);
  EXPECT_NEAR(0.5 * (w[3].Fz - w[2].Fz), moved_rear, 0.01 * moved_rear);
}

TEST(Loads, FollowTheForcesWithTheirLag) {
  const Params p = bare();
  DoubleTrackCar car(p);
  const Road road;
  car.reset(rolling(20.0), road);
  const double h = p.step;
  double along = 0.0;  // forces through a first-order lag, filtered here
  double across = 0.0;
  double largest = 0.0;
  for (int k = 0; k < 800; ++k) {
    car.advance(-0.4, 0.05, h, road);
    const auto& w = car.loads();
    const double steer = car.motion().steer;  // the front wheels' angles differ from it by less than a hundredth
    const double Fx_front = (w[0].Fx + w[1].Fx) * std::cos(steer) - (w[0].Fy + w[1].Fy) * std::sin(steer);
    const double Fy_front = (w[0].Fy + w[1].Fy) * std::cos(steer) + (w[0].Fx + w[1].Fx) * std::sin(steer);
    along += h / p.load_lag * (Fx_front + w[2].Fx + w[3].Fx - along);
    across += h / p.load_lag * (Fy_front + w[2].Fy + w[3].Fy - across);
    const double moment = 0.5 * (w[1].Fz - w[0].Fz) * p.track_front + 0.5 * (w[3].Fz - w[2].Fz) * p.track_rear;
    const double front = p.m * gravity * p.lr / (p.lf + p.lr);
    ASSERT_NEAR(moment, across * p.h, 30.0) << k;
    ASSERT_NEAR(w[0].Fz + w[1].Fz, front - along * p.h / (p.lf + p.lr), 15.0) << k;
    largest = std::max(largest, moment);
  }
  EXPECT_GT(largest, 2000.0);
}

}  // namespace test_double_track_loads
}  // namespace gripline::double_track
