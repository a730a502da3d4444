// The full-size car against closed-form cases.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "plugin/registry.hpp"
#include "support/double_track_rig.hpp"
#include "support/paths.hpp"
#include "util/clock.hpp"

namespace gripline::double_track {
namespace test_double_track {

using testing::HasSubstr;

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

/// Seeded cars that roll, slide, spin, roll backwards or stand.
std::vector<State> wild_states(int count) {
  std::mt19937_64 random(13);
  const auto uniform = [&](double most) { return std::uniform_real_distribution<double>(-most, most)(random); };
  const double sizes[] = {0.0, 1e-6, 0.05, 1.0, 15.0};
  std::vector<State> all;
  for (int i = 0; i < count; ++i) {
    State x;
    x.yaw = uniform(3);
    x.vx = uniform(sizes[random() % 5]);
    x.vy = uniform(sizes[random() % 5]);
    x.omega = 0.3 * uniform(sizes[random() % 5]);
    x.delta = uniform(0.5);
    all.push_back(x);
  }
  return all;
}

TEST(Car, MirrorSymmetryFromAnyState) {
  const Params p;
  DoubleTrackCar left(p), right(p);
  Road road, mirrored;
  road.grade = mirrored.grade = -0.05;
  road.bank = 0.06;
  mirrored.bank = -0.06;
  int k = 0;
  for (State x : wild_states(40)) {
    const double d = std::sin(0.8 * ++k), delta = x.delta;
    left.reset(x, road);
    x.yaw = -x.yaw, x.vy = -x.vy, x.omega = -x.omega, x.delta = -x.delta;
    right.reset(x, mirrored);
    for (int step = 0; step < 10; ++step) {
      left.advance(d, delta, control_step, road);
      right.advance(d, -delta, control_step, mirrored);
    }
    const Motion &a = left.motion(), &b = right.motion();
    EXPECT_NEAR(a.vx, b.vx, 1e-8) << k;
    EXPECT_NEAR(a.vy, -b.vy, 1e-8) << k;
    EXPECT_NEAR(a.omega, -b.omega, 1e-8) << k;
    for (const std::size_t i : {0u, 2u}) {
      EXPECT_NEAR(a.spin[i], b.spin[i + 1], 1e-6) << k;
      EXPECT_NEAR(left.loads()[i].Fz, right.loads()[i + 1].Fz, 1e-3) << k;
    }
  }
}

/// Kinetic energy, of wheels too, grows by no more than what the carcasses of the tyres can give back. A carcass
/// of k = stiffness / relaxation under F = mu Fz holds F^2 / (2 k); but one that slid comes back over int sigma(s)
/// ds, under the full force until s is that of the peak: F^2 / k (1 / 2 + ln(s)), s up to 1 over the slip of the
/// peak, above 0.08.
TEST(Car, WithoutDriveItOnlyLosesEnergyFromAnyState) {
  const Params p = bare();
  const double load = 0.25 * p.m * gravity, carcass = p.stiffness_front * load / p.relaxation_y;
  const double stored = 4.0 * std::pow(p.mu_y * load, 2) / carcass * (0.5 + std::log(1.0 / 0.08));
  const Road road;
  int k = 0;
  for (const State& x : wild_states(60)) {
    DoubleTrackCar car(p);
    car.reset(x, road);
    const double d = ++k % 2 == 0 ? 0.0 : -0.7;
    double least = energy(car);
    for (int step = 0; step < 50; ++step) {
      car.advance(d, x.delta, control_step, road);
      EXPECT_LT(energy(car), least + stored) << k;
      least = std::min(least, energy(car));
    }
    if (d < 0.0) {
      drive(car, d, x.delta, 12.0, road);
      EXPECT_LT(energy(car), 1e-6) << k;  // it has come to rest
    }
  }
}

TEST(Car, ForcesStayInTheFrictionEllipseAndLoadsAddUpFromAnyState) {
  Params p;
  p.load_sensitivity = 0.0;
  for (const double factor : {1.0, 0.3, 1e-9, 0.0}) {
    Road road;
    road.factor = factor;
    road.grade = 0.05;
    road.bank = -0.08;
    const double normal = gravity * std::sqrt(1.0 - std::pow(std::sin(0.05), 2) - std::pow(std::sin(0.08), 2));
    int k = 0;
    for (const State& x : wild_states(40)) {
      DoubleTrackCar car(p);
      car.reset(x, road);
      for (int step = 0; step < 10; ++step) {
        car.advance(std::sin(1.0 * ++k), x.delta, control_step, road);
        const Motion& z = car.motion();
        double sum = 0.0;
        for (const WheelLoads& w : car.loads()) {
          const double limit = factor * w.Fz;
          EXPECT_GE(w.Fz, 0.0);
          EXPECT_LE(std::pow(w.Fx / p.mu_x, 2) + std::pow(w.Fy / p.mu_y, 2), (1.0 + 1e-9) * limit * limit);
          sum += w.Fz;
        }
        const double down = (p.downforce_front + p.downforce_rear) * (z.vx * z.vx + z.vy * z.vy);
        EXPECT_NEAR(sum, p.m * normal + down, 1e-6);
        EXPECT_TRUE(std::isfinite(z.vx + z.vy + z.omega + z.spin[0] + z.spin[3]));
      }
    }
  }
}

TEST(Car, BackwardsBrakesStopItAndSlipControlKeepsWheelsTurning) {
  Params p;
  Road road;
  road.factor = 0.4;
  double distance[2] = {0.0, 0.0};
  bool locked[2] = {false, false};
  for (const bool control : {false, true}) {
    p.slip_control = control;
    DoubleTrackCar car(p);
    car.reset(rolling(-20.0), road);
    for (int k = 0; k < 1000; ++k) {
      car.advance(-1.0, 0.0, control_step, road);
      if (car.motion().vx < -5.0 && (car.motion().spin[0] > -1.0 || car.motion().spin[2] > -1.0))
        locked[control ? 1 : 0] = true;
    }
    EXPECT_NEAR(car.motion().vx, 0.0, 1e-8);
    distance[control ? 1 : 0] = -car.motion().x;
  }
  EXPECT_TRUE(locked[0]);
  EXPECT_FALSE(locked[1]);
  EXPECT_LT(distance[1], distance[0]);
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
  const double begin = thread_cpu_s();
  drive(car, 0.3, 0.03, 40.0, road);
  EXPECT_LT((thread_cpu_s() - begin) / 40.0, 1.0 / 100.0);
}

TEST(BadInput, ParametersThatDoNotFitTogether) {
  EXPECT_THAT(complaint([](Params& p) { p.slip_end = 0.05; }), HasSubstr("expected slip_end above slip_start"));
  EXPECT_THAT(complaint([](Params& p) { p.h = 0.05; }), HasSubstr("expected none above h"));
}

TEST(Plugin, LoadsAndDrivesAsAPlant) {
  const Registry registry({testing_support::plugin_dir()});
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
  const auto plant = create<Plant>(entry, PluginContext{}, values);
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

}  // namespace test_double_track
}  // namespace gripline::double_track
