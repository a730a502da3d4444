// Engine, gearbox, brakes and slip control of the full-size car.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/double_track_rig.hpp"

namespace gripline::double_track {
namespace test_drivetrain {

using testing::HasSubstr;

Engine small_engine() {
  static constexpr std::array<double, 9> rows{100, 200, 20, 300, 400, 40, 500, 300, 60};
  return Engine(Table{rows.data(), 3, 3});
}
GearMap three_gears() {
  static constexpr std::array<double, 12> rows{1, 3, 0, 10, 2, 2, 8, 20, 3, 1, 16, 90};
  return GearMap(Table{rows.data(), 3, 4});
}

/// Shares of the front axle in the torques at the wheels, and their sums [N m].
struct Torques {
  double drive = 0, resistance = 0, drive_front = 0, resistance_front = 0;
};
Torques torques(const DoubleTrackCar& car) {
  Torques sum;
  for (std::size_t i = 0; i < wheels; ++i) {
    sum.drive += car.loads()[i].drive;
    sum.resistance += car.loads()[i].resistance;
  }
  sum.drive_front = (car.loads()[0].drive + car.loads()[1].drive) / sum.drive;
  sum.resistance_front = (car.loads()[0].resistance + car.loads()[1].resistance) / sum.resistance;
  return sum;
}

TEST(Engine, TorqueOverSpeedAndThrottle) {
  const Engine engine = small_engine();
  EXPECT_DOUBLE_EQ(engine.torque(1.0, 200.0), 300.0);
  EXPECT_DOUBLE_EQ(engine.torque(0.0, 400.0), -50.0);  // it brakes
  EXPECT_DOUBLE_EQ(engine.torque(0.25, 400.0), 0.25 * 350.0 - 0.75 * 50.0);
}

TEST(Engine, ClutchSlipsBelowIdleAndFuelIsCutAtTheEnd) {
  const Engine engine = small_engine();
  EXPECT_DOUBLE_EQ(engine.torque(1.0, 0.0), 200.0);
  EXPECT_DOUBLE_EQ(engine.torque(0.0, 0.0), 0.0);
  EXPECT_DOUBLE_EQ(engine.torque(0.0, 75.0), -10.0);
  EXPECT_DOUBLE_EQ(engine.torque(1.0, 510.0), 150.0);
  EXPECT_DOUBLE_EQ(engine.torque(1.0, 520.0), 0.0);
  EXPECT_DOUBLE_EQ(engine.torque(0.0, 520.0), -60.0);
}

TEST(Gearbox, RangesOverlapForHysteresis) {
  const GearMap map = three_gears();
  EXPECT_EQ(map.next(0, 9.0), 0);
  EXPECT_EQ(map.next(1, 9.0), 1);
  EXPECT_EQ(map.next(0, 10.1), 1);
  EXPECT_EQ(map.next(1, 7.9), 0);
  EXPECT_EQ(map.next(2, 12.0), 1);
  EXPECT_EQ(map.next(2, 200.0), 2);
  EXPECT_EQ(map.at(9.0), 1);
  EXPECT_EQ(map.at(0.0), 0);
}

TEST(Gearbox, TorqueGoesToZeroAndComesBackWhileItChanges) {
  Gearbox box(three_gears(), 0.2);
  box.reset(5.0);
  EXPECT_EQ(box.gear(), 1);
  const double step = 0.001;
  double torque_time = 0.0;
  double least = 1.0;
  int changed_at = 0;
  for (int k = 1; k <= 300; ++k) {
    box.advance(11.0, step);
    torque_time += step * (1.0 - box.engaged());
    least = std::min(least, box.engaged());
    if (changed_at == 0 && box.gear() == 2) changed_at = k;
  }
  EXPECT_NEAR(torque_time, 0.1, 0.002);  // a triangle of the change's duration
  EXPECT_NEAR(least, 0.0, 0.01);
  EXPECT_NEAR(changed_at, 101, 1);  // when no torque is on it
  EXPECT_EQ(box.engaged(), 1.0);
  for (int k = 0; k < 600; ++k) box.advance(7.0, step);
  EXPECT_EQ(box.gear(), 1);
}

TEST(Car, TorquesAreSplitBetweenTheAxles) {
  Params p;
  p.rolling = 0.0;
  p.drive_front = 0.3;
  p.brake_bias = 0.7;
  DoubleTrackCar car(p);
  const Road road;
  car.reset(rolling(20.0), road);
  car.advance(0.5, 0.0, 0.5, road);
  EXPECT_GT(torques(car).drive, 500.0);
  EXPECT_NEAR(torques(car).drive_front, 0.3, 1e-9);
  car.advance(-0.5, 0.0, 0.5, road);
  EXPECT_NEAR(torques(car).resistance, 0.5 * p.brake_torque, 1.0);
  EXPECT_NEAR(torques(car).resistance_front, 0.7, 1e-9);
}

TEST(Car, TheEngineBrakesAtClosedThrottle) {
  const Params p;
  DoubleTrackCar car(p);
  const Road road;
  car.reset(rolling(36.0), road);
  car.advance(0.0, 0.0, 1.0, road);
  EXPECT_EQ(car.gear(), 4);
  const double ratio = 0.919 * p.final_drive;
  const double speed = car.motion().vx / p.radius * ratio;
  const double drag = 31 + (speed - 209) / (471 - 209) * (46 - 31);
  EXPECT_NEAR(torques(car).drive, -drag * ratio, 0.01 * drag * ratio);
}

TEST(Car, PedalsActWithTheirLags) {
  const Params p;
  DoubleTrackCar car(p);
  const Road road;
  car.reset(rolling(30.0), road);
  car.advance(-1.0, 0.0, p.brake_lag, road);
  EXPECT_NEAR(car.motion().brake, 1.0 - std::exp(-1.0), 1e-3);
  car.reset(rolling(30.0), road);
  car.advance(1.0, 0.0, p.engine_lag, road);
  EXPECT_NEAR(car.motion().throttle, 1.0 - std::exp(-1.0), 1e-3);
}

TEST(Car, SlipControlKeepsDrivenWheelsFromSpinning) {
  Params p;
  Road ice;
  ice.factor = 0.2;
  double way[2];
  double fastest[2] = {0.0, 0.0};  // surplus of a wheel's speed over the car's [m/s]
  for (const bool control : {false, true}) {
    p.slip_control = control;
    DoubleTrackCar car(p);
    car.reset(rolling(5.0), ice);
    const auto i = static_cast<std::size_t>(control);
    for (int k = 0; k < 200; ++k) {
      car.advance(1.0, 0.0, 0.02, ice);
      for (const double spin : car.motion().spin) fastest[i] = std::max(fastest[i], p.radius * spin - car.motion().vx);
    }
    way[i] = car.motion().x;
  }
  EXPECT_GT(fastest[0], 10.0);
  EXPECT_LT(fastest[1], 2.5);
  EXPECT_GT(way[1], way[0]);
}

template <std::size_t n>
std::string engine_complaint(const std::array<double, n>& rows) {
  return complaint([&](Params& p) { p.engine_torque = {rows.data(), n / 3, 3}; });
}
template <std::size_t n>
std::string gear_complaint(const std::array<double, n>& rows) {
  return complaint([&](Params& p) { p.gears = {rows.data(), n / 4, 4}; });
}

TEST(BadInput, EngineTable) {
  EXPECT_THAT(engine_complaint(std::array<double, 9>{100, 300, 20, 400, 350, 20, 300, 340, 20}),
              HasSubstr("goes back: row 3 is at 300 rad/s after 400 rad/s"));
  EXPECT_THAT(engine_complaint(std::array<double, 3>{100, 300, 20}), HasSubstr("expected at least 2"));
  EXPECT_THAT(engine_complaint(std::array<double, 6>{100, 300, -20, 400, 350, 20}), HasSubstr("none below 0"));
  EXPECT_THAT(engine_complaint(std::array<double, 6>{0, 300, 20, 400, 350, 20}), HasSubstr("expected the idle speed"));
  const std::array<double, 4> square{100, 300, 400, 300};
  EXPECT_THAT(complaint([&](Params& p) { p.engine_torque = {square.data(), 2, 2}; }), HasSubstr("expected 3"));
}

TEST(BadInput, GearMap) {
  EXPECT_THAT(gear_complaint(std::array<double, 8>{1, 3, 0, 10, 2, 2, 12, 20}),
              HasSubstr("gap: gear 1 ends at 10 m/s and gear 2 begins at 12 m/s"));
  EXPECT_THAT(gear_complaint(std::array<double, 8>{1, 3, 0, 10, 3, 2, 8, 20}),
              HasSubstr("gap: row 2 is gear 3, expected gear 2"));
  EXPECT_THAT(gear_complaint(std::array<double, 4>{1, 3, 2, 10}), HasSubstr("begins at 2 m/s, expected 0"));
  EXPECT_THAT(gear_complaint(std::array<double, 8>{1, 2, 0, 10, 2, 3, 8, 20}), HasSubstr("expected ratios that fall"));
  EXPECT_THAT(gear_complaint(std::array<double, 4>{1, 2, 0, 0}), HasSubstr("range that is not empty"));
  EXPECT_THAT(gear_complaint(std::array<double, 8>{1, 3, 0, 20, 2, 2, 8, 15}), HasSubstr("expected both above gear 1"));
}

}  // namespace test_drivetrain
}  // namespace gripline::double_track
