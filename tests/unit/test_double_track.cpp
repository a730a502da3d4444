// The full-size car against closed-form cases.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <ctime>
#include <functional>
#include <vector>

#include "plants/double_track/car.hpp"
#include "registry.hpp"

namespace gripline::double_track {
namespace {

using testing::HasSubstr;

/// A plane, the same everywhere unless `factor_at` says otherwise.
struct Road final : Ground {
  double grade = 0, bank = 0, factor = 1;
  std::function<double(double x, double y)> factor_at;
  Patch at(double x, double y, double) const override { return {grade, bank, factor_at ? factor_at(x, y) : factor}; }
};

constexpr double control_step = 0.02;

State rolling(double speed) {
  State x;
  x.vx = speed;
  return x;
}

/// Nothing but tyres and inertia: no drag, no rolling resistance, no downforce, an engine without drag.
Params bare() {
  static constexpr std::array<double, 6> engine{84, 500, 0, 740, 500, 0};
  Params p;
  p.drag = p.rolling = p.downforce_front = p.downforce_rear = 0;
  p.engine_torque = {engine.data(), 2, 3};
  return p;
}

double effective_mass(const Params& p) { return p.m + 4.0 * p.wheel_inertia / (p.radius * p.radius); }

void drive(DoubleTrackCar& car, double d, double delta, double seconds, const Ground& road) {
  const int steps = static_cast<int>(std::lround(seconds / control_step));
  for (int k = 0; k < steps; ++k) car.advance(d, delta, control_step, road);
}

/// Holds speed and yaw rate on a circle until nothing changes; returns the steering angle.
double settle_on_circle(DoubleTrackCar& car, double speed, double radius, const Ground& road) {
  car.reset(rolling(speed), road);
  double delta = 2.64 / radius;
  double d = 0.0;
  for (int k = 0; k < 3000; ++k) {
    const Motion& z = car.motion();
    d = std::clamp(d + 0.004 * (speed - z.vx), -0.2, 1.0);
    delta += 0.002 * (speed / radius - z.omega);
    car.advance(std::clamp(d + 0.3 * (speed - z.vx), -1.0, 1.0), delta, control_step, road);
  }
  return delta;
}

double energy(const DoubleTrackCar& car) {
  const Motion& z = car.motion();
  const Params& p = car.params();
  double sum = 0.5 * p.m * (z.vx * z.vx + z.vy * z.vy) + 0.5 * p.Iz * z.omega * z.omega;
  for (const double spin : z.spin) sum += 0.5 * p.wheel_inertia * spin * spin;
  return sum;
}

struct Power {
  double in = 0, out = 0;  // from engine and gravity; into brakes, tyres, air [W]
};
Power power(const DoubleTrackCar& car, const Road& road) {
  const Motion& z = car.motion();
  const Params& p = car.params();
  const double speed = std::hypot(z.vx, z.vy);
  Power sum;
  sum.in = p.m * gravity * (std::sin(road.bank) * z.vy - std::sin(road.grade) * z.vx);
  sum.out = p.drag * speed * speed * speed;
  for (std::size_t i = 0; i < wheels; ++i) {
    const WheelLoads& w = car.loads()[i];
    sum.in += w.drive * z.spin[i];
    sum.out += w.resistance * z.spin[i] + w.Fx * (p.radius * z.spin[i] - w.Vx) - w.Fy * w.Vy;
  }
  return sum;
}

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

TEST(Car, UndersteerGradientOnACircle) {
  const Params p = bare();
  DoubleTrackCar car(p);
  const Road road;
  const double radius = 200.0;
  const double slow = std::sqrt(0.05 * gravity * radius);
  const double quick = std::sqrt(0.15 * gravity * radius);
  const double gradient =
      (settle_on_circle(car, quick, radius, road) - settle_on_circle(car, slow, radius, road)) / 0.10;
  // Wf / Cf - Wr / Cr, with stiffnesses given over the loads
  const double expected = 1.0 / p.stiffness_front - 1.0 / p.stiffness_rear;
  EXPECT_NEAR(gradient, expected, 0.05 * expected);
}

TEST(Car, LimitOnACircleIsJustBelowThePeak) {
  const Params p;
  DoubleTrackCar car(p);
  const Road road;
  settle_on_circle(car, 27.0, 80.0, road);  // 0.93 g
  EXPECT_NEAR(car.motion().vx * car.motion().omega, 27.0 * 27.0 / 80.0, 0.05);
  settle_on_circle(car, 29.5, 80.0, road);  // 1.11 g is too much
  EXPECT_LT(car.motion().vx * car.motion().omega, 1.05 * gravity);
}

TEST(Car, BrakingDistance) {
  Params p = bare();
  p.drag = 0.5;
  p.rolling = 0.01;
  p.brake_lag = 0.001;
  DoubleTrackCar car(p);
  const Road road;
  car.reset(rolling(30.0), road);
  for (int k = 0; k < 2000 && car.motion().vx > 0.05; ++k) car.advance(-0.7, 0.0, control_step, road);
  // (m + 4 I / r^2) v dv = -(T / r + f_r m g + D v^2) ds
  const double force = 0.7 * p.brake_torque / p.radius + p.rolling * p.m * gravity;
  const double distance = effective_mass(p) / (2.0 * p.drag) * std::log(1.0 + p.drag * 900.0 / force);
  EXPECT_NEAR(car.motion().x, distance, 0.01 * distance);
}

TEST(Car, SlipControlBrakesAtTheFrictionLimit) {
  Params p;
  const Road road = [] {
    Road r;
    r.factor = 0.4;
    return r;
  }();
  double distance[2] = {0.0, 0.0};
  bool locked[2] = {false, false};
  for (const bool control : {false, true}) {
    p.slip_control = control;
    DoubleTrackCar car(p);
    car.reset(rolling(30.0), road);
    for (int k = 0; k < 3000 && car.motion().vx > 0.01; ++k) {
      car.advance(-1.0, 0.0, control_step, road);
      if (car.motion().vx > 5.0 && car.motion().spin[0] < 1.0) locked[control ? 1 : 0] = true;
    }
    distance[control ? 1 : 0] = car.motion().x;
  }
  EXPECT_TRUE(locked[0]);
  EXPECT_FALSE(locked[1]);
  EXPECT_LT(distance[1], distance[0]);
  EXPECT_GT(distance[1], 900.0 / (2.0 * 1.05 * 0.4 * p.mu_x * gravity));
}

TEST(Car, CoastDown) {
  Params p = bare();
  p.drag = 0.5;
  p.rolling = 0.01;
  DoubleTrackCar car(p);
  const Road road;
  car.reset(rolling(40.0), road);
  drive(car, 0.0, 0.0, 60.0, road);
  const double force = p.rolling * p.m * gravity;
  const double speed = std::sqrt(force / p.drag) * std::tan(std::atan(40.0 * std::sqrt(p.drag / force)) -
                                                            60.0 * std::sqrt(force * p.drag) / effective_mass(p));
  EXPECT_NEAR(car.motion().vx, speed, 0.01);
}

TEST(Car, RollsDownAHillWithoutLosses) {
  const Params p = bare();
  DoubleTrackCar car(p);
  Road road;
  road.grade = -0.08;
  car.reset({}, road);
  drive(car, 0.0, 0.0, 10.0, road);
  const double speed = gravity * std::sin(0.08) * p.m / effective_mass(p) * 10.0;
  EXPECT_NEAR(car.motion().vx, speed, 0.002 * speed);
}

TEST(Car, TopSpeed) {
  const Params p;
  DoubleTrackCar car(p);
  const Road road;
  car.reset(rolling(75.0), road);
  drive(car, 1.0, 0.0, 90.0, road);
  // engine torque of the default table over speed, in sixth gear, against drag and rolling resistance
  const auto surplus = [&](double v) {
    const double ratio = 0.60 * p.final_drive;
    const double speed = v / p.radius * ratio;
    const double torque = speed < 471 ? 550 : 550 + (speed - 471) / (550 - 471) * (471 - 550);
    const double load = p.m * gravity + (p.downforce_front + p.downforce_rear) * v * v;
    return torque * ratio / p.radius - p.drag * v * v - p.rolling * load;
  };
  double lo = 20.0;
  double hi = 120.0;
  while (hi - lo > 1e-6) (surplus(0.5 * (lo + hi)) > 0.0 ? lo : hi) = 0.5 * (lo + hi);
  EXPECT_EQ(car.gear(), 6);
  EXPECT_NEAR(car.motion().vx, lo, 0.005 * lo);
}

TEST(Car, EnergyBalance) {
  Params p;
  p.step = 1e-4;
  DoubleTrackCar car(p);
  Road road;
  road.grade = -0.05;
  road.bank = 0.03;
  car.reset(rolling(20.0), road);
  const double before = energy(car);
  const double h = 1e-4;
  double balance = 0.0;
  double turned_over = 0.0;
  Power last = power(car, road);
  for (int k = 0; k < 80000; ++k) {
    const double t = k * h;
    car.advance(std::sin(1.7 * t), 0.06 * std::sin(2.3 * t), h, road);
    const Power now = power(car, road);
    balance += 0.5 * h * (now.in - now.out + last.in - last.out);
    turned_over += 0.5 * h * (std::abs(now.in) + std::abs(now.out) + std::abs(last.in) + std::abs(last.out));
    last = now;
  }
  EXPECT_GT(turned_over, 2.5 * before);
  EXPECT_NEAR(energy(car) - before, balance, 2e-4 * turned_over);
}

TEST(Car, TyresOnlyLosePower) {
  const Params p;
  DoubleTrackCar car(p);
  const Road road;
  car.reset(rolling(25.0), road);
  double worked = 0.0;
  for (int k = 0; k < 4000; ++k) {
    const double t = 0.005 * k;
    car.advance(0.4 * std::sin(0.9 * t), 0.08 * std::sin(1.3 * t), 0.005, road);
    for (std::size_t i = 0; i < wheels; ++i) {
      const WheelLoads& w = car.loads()[i];
      worked += 0.005 * (w.Fx * (w.Vx - p.radius * car.motion().spin[i]) + w.Fy * w.Vy);
    }
  }
  EXPECT_LT(worked, 0.0);
}

TEST(Car, MirrorSymmetry) {
  const Params p;
  DoubleTrackCar left(p);
  DoubleTrackCar right(p);
  Road road;
  road.grade = 0.04;
  road.bank = 0.05;
  road.factor_at = [](double, double y) { return y > 1.0 ? 0.7 : 1.0; };
  Road mirrored = road;
  mirrored.bank = -road.bank;
  mirrored.factor_at = [&](double x, double y) { return road.factor_at(x, -y); };
  left.reset(rolling(25.0), road);
  right.reset(rolling(25.0), mirrored);
  for (int k = 0; k < 400; ++k) {
    const double t = control_step * k;
    const double d = 0.7 * std::sin(1.1 * t);
    const double delta = 0.05 * std::sin(2.0 * t) + 0.02;
    left.advance(d, delta, control_step, road);
    right.advance(d, -delta, control_step, mirrored);
    const Motion& a = left.motion();
    const Motion& b = right.motion();
    ASSERT_NEAR(a.x, b.x, 1e-7);
    ASSERT_NEAR(a.y, -b.y, 1e-7);
    ASSERT_NEAR(a.omega, -b.omega, 1e-7);
    ASSERT_NEAR(a.spin[0], b.spin[1], 1e-6);
    ASSERT_NEAR(left.axle_force(Axle::rear), -right.axle_force(Axle::rear), 1e-3);
  }
  EXPECT_GT(std::abs(left.motion().yaw), 0.1);
}

TEST(Car, RestStaysAtRestOnAHill) {
  const Params p;
  for (const double grade : {0.08, -0.08}) {
    DoubleTrackCar car(p);
    Road road;
    road.grade = grade;
    road.bank = 0.087;
    car.reset({}, road);
    drive(car, -1.0, 0.1, 5.0, road);  // settles on its tyres
    const Motion settled = car.motion();
    EXPECT_LT(std::hypot(settled.x, settled.y), 0.01);
    drive(car, -1.0, 0.1, 300.0, road);
    EXPECT_NEAR(car.motion().x, settled.x, 1e-6);
    EXPECT_NEAR(car.motion().y, settled.y, 1e-6);
    EXPECT_NEAR(car.motion().yaw, settled.yaw, 1e-7);
    EXPECT_EQ(car.motion().spin[0], 0.0);
  }
}

TEST(Car, BrakesToAStandstillOnAHillAndStays) {
  Params p;
  for (const bool control : {true, false}) {
    p.slip_control = control;
    for (const double grade : {0.08, -0.08}) {
      DoubleTrackCar car(p);
      Road road;
      road.grade = grade;
      road.factor = 0.5;
      car.reset(rolling(12.0), road);
      drive(car, -1.0, 0.0, 12.0, road);
      const double stopped = car.motion().x;
      drive(car, -1.0, 0.0, 30.0, road);
      EXPECT_NEAR(car.motion().x, stopped, 1e-6) << grade << control;
      EXPECT_NEAR(car.motion().vx, 0.0, 1e-8);
    }
  }
}

TEST(Car, WithoutBrakesItRollsAndRollingResistanceHoldsAFlatHill) {
  Params p;
  p.rolling = 0.01;
  DoubleTrackCar car(p);
  Road road;
  road.grade = 0.03;
  car.reset({}, road);
  drive(car, 0.0, 0.0, 5.0, road);
  EXPECT_NEAR(car.motion().vx, -5.0 * gravity * (std::sin(0.03) - 0.01) * p.m / effective_mass(p), 0.02);
  road.grade = 0.005;
  car.reset({}, road);
  drive(car, 0.0, 0.0, 30.0, road);
  EXPECT_LT(std::abs(car.motion().x), 0.01);
  EXPECT_NEAR(car.motion().vx, 0.0, 1e-9);
}

TEST(Car, BrakesAndDriveActPerWheel) {
  Params p = bare();
  p.slip_control = false;
  DoubleTrackCar car(p);
  Road road;
  road.factor_at = [](double, double y) { return y > 0.0 ? 0.15 : 1.0; };  // ice under the left wheels
  car.reset(rolling(25.0), road);
  drive(car, -0.8, 0.0, 0.4, road);
  EXPECT_LT(car.motion().omega, -0.05);  // turns to the side that grips, the right
  EXPECT_LT(std::abs(car.loads()[0].Fx), std::abs(car.loads()[1].Fx));
}

TEST(Car, SteeringLagsAndIsLimitedInRate) {
  const Params p;
  DoubleTrackCar car(p);
  const Road road;
  car.reset(rolling(5.0), road);
  drive(car, 0.1, 0.3, 0.1, road);
  EXPECT_LE(car.motion().steer, p.steer_rate * 0.1 + 1e-12);
  EXPECT_GT(car.motion().steer, 0.9 * p.steer_rate * 0.1);
  drive(car, 0.1, 0.3, 1.0, road);
  EXPECT_NEAR(car.motion().steer, 0.3, 1e-6);
}

TEST(Car, InnerWheelSteersMore) {
  Params p = bare();
  for (const double ackermann : {0.0, 0.6, 1.0}) {
    p.ackermann = ackermann;
    DoubleTrackCar car(p);
    const Road road;
    car.reset(rolling(5.0), road);
    drive(car, 0.02, 0.3, 2.0, road);
    const Motion& z = car.motion();
    const auto angle = [&](std::size_t wheel, double py) {
      const WheelLoads& w = car.loads()[wheel];
      return std::atan2(z.vy + z.omega * p.lf, z.vx - z.omega * py) - std::atan2(w.Vy, w.Vx);
    };
    const double left = angle(0, 0.5 * p.track_front);
    const double right = angle(1, -0.5 * p.track_front);
    // Ackermann: cot(outer) - cot(inner) = track / wheelbase
    EXPECT_NEAR(1.0 / std::tan(right) - 1.0 / std::tan(left), ackermann * p.track_front / (p.lf + p.lr), 1e-6);
  }
}

TEST(Car, StartsFromRestAndChangesGear) {
  const Params p;
  DoubleTrackCar car(p);
  const Road road;
  car.reset({}, road);
  int changes = 0;
  int gear = car.gear();
  for (int k = 0; k < 500; ++k) {
    car.advance(1.0, 0.0, control_step, road);
    if (car.gear() != gear) ++changes;
    EXPECT_GE(car.gear(), gear);
    gear = car.gear();
  }
  EXPECT_GT(car.motion().vx, 35.0);
  EXPECT_EQ(gear, 4);
  EXPECT_EQ(changes, 3);
  // fourth gear, full throttle: the published 550 N m through 3.45 x 0.919 on 0.34 m
  double Fx = 0.0;
  for (const WheelLoads& w : car.loads()) Fx += w.drive / p.radius;
  EXPECT_NEAR(Fx, 550 * 3.45 * 0.919 / 0.34, 1.0);
}

TEST(Car, HalvingTheStepChangesNothingThatMatters) {
  Params p;
  const Road road;
  Motion end[2];
  for (const int fine : {0, 1}) {
    p.step = fine != 0 ? 1e-4 : Params{}.step;
    DoubleTrackCar car(p);
    car.reset(rolling(20.0), road);
    for (int k = 0; k < 300; ++k) {
      const double t = control_step * k;
      car.advance(0.5 * std::sin(t), 0.06 * std::sin(3.0 * t), control_step, road);
    }
    end[fine] = car.motion();
  }
  EXPECT_NEAR(end[0].x, end[1].x, 0.01);
  EXPECT_NEAR(end[0].y, end[1].y, 0.01);
  EXPECT_NEAR(end[0].omega, end[1].omega, 1e-3);
}

TEST(Car, SameBytesAgainAndInterleaved) {
  const Params p;
  Road road;
  road.grade = 0.05;
  DoubleTrackCar alone(p);
  alone.reset(rolling(15.0), road);
  for (int k = 0; k < 200; ++k) alone.advance(std::sin(0.1 * k), 0.05 * std::cos(0.07 * k), control_step, road);
  DoubleTrackCar a(p);
  DoubleTrackCar b(p);
  a.advance(1.0, 0.2, 1.0, road);  // a past that reset must forget
  a.reset(rolling(15.0), road);
  b.reset(rolling(30.0), road);
  for (int k = 0; k < 200; ++k) {
    a.advance(std::sin(0.1 * k), 0.05 * std::cos(0.07 * k), control_step, road);
    b.advance(0.3, -0.02, control_step, road);
  }
  EXPECT_EQ(std::memcmp(&alone.motion(), &a.motion(), sizeof(Motion)), 0);
}

TEST(Car, HundredTimesFasterThanRealTime) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "built with sanitizers";
#endif
  const Params p;
  DoubleTrackCar car(p);
  const Road road;
  car.reset(rolling(25.0), road);
  const auto cpu = [] {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  };
  const double begin = cpu();
  drive(car, 0.3, 0.03, 40.0, road);
  EXPECT_LT((cpu() - begin) / 40.0, 1.0 / 100.0);
}

std::string complaint(const std::function<void(Params&)>& change) {
  Params p;
  change(p);
  try {
    const DoubleTrackCar car(p);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "nothing";
}

TEST(BadInput, ParametersThatDoNotFitTogether) {
  EXPECT_THAT(complaint([](Params& p) { p.slip_end = 0.05; }), HasSubstr("expected slip_end above slip_start"));
  EXPECT_THAT(complaint([](Params& p) { p.h = 0.05; }), HasSubstr("expected none above h"));
}

TEST(Plugin, LoadsAndDrivesAsAPlant) {
  const Registry registry({GRIPLINE_PLUGIN_DIR});
  const PluginEntry& entry = registry.find(abi::Kind::plant, "double_track");
  std::vector<abi::ParamValue> values;
  for (const abi::ParamDecl& decl : entry.params()) {
    values.push_back({decl.default_value, {}});
    EXPECT_GE(std::strlen(decl.doc), 10u) << decl.name;
    if (decl.type != abi::ParamType::table) {
      EXPECT_LE(decl.lo, decl.default_value) << decl.name;
      EXPECT_GE(decl.hi, decl.default_value) << decl.name;
    }
  }
  const auto plant = create<Plant>(entry, Surroundings{}, values);
  EXPECT_DOUBLE_EQ(plant->mu(Axle::front), 1.05);
  EXPECT_GT(plant->tyre_force(Axle::front, 0.05), 0.0);
  const Road road;
  plant->reset(rolling(20.0), road);
  const State end = plant->advance(0.2, 0.03, 1.0, road);
  EXPECT_DOUBLE_EQ(end.delta, 0.03);
  EXPECT_GT(end.omega, 0.1);
  EXPECT_GT(plant->axle_force(Axle::front), 1000.0);
  EXPECT_NEAR(plant->axle_force(Axle::rear), plant->axle_force(Axle::front), 1000.0);
}

}  // namespace
}  // namespace gripline::double_track
