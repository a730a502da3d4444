#include "measured/session/guess_commands.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <string>

#include "config/json_file.hpp"
#include "measured/session/session_file.hpp"
#include "support/guess_of_columns.hpp"
#include "support/session_logs.hpp"

namespace gripline::measured {
namespace test_guess_commands {

using std::numbers::pi;
using test::guess_of_columns;
using testing_support::scratch;

TEST(GuessCommands, AnAngleOfTheSteeringWheelIsToldByItsName) {
  for (const char* name : {"SteeringWheel", "SWA", "HandWheelAngle"}) {
    const auto file = scratch("wheel.csv");
    std::ofstream out(file);
    out << "time,x,y," << name << '\n';
    for (int k = 0; k < 100; ++k) out << 0.1 * k << ',' << k << ",1," << 0.3 * std::sin(0.1 * k) << '\n';
    out.close();
    const Guess guess = guess_map(read_delimited(file));
    EXPECT_TRUE(guess.open.empty()) << name;
    EXPECT_EQ(find_pointer(guess.map, "/channels/delta/formula")->text(), std::string(name) + " / 15");
    EXPECT_THAT(guess.remarks, testing::Contains(testing::HasSubstr("steering ratio")));
  }
}

/// A dead man's switch that is written less often than the throttle.
TEST(GuessCommands, ASwitchOfTheDriveHoldsUntilItIsReadAgain) {
  const auto log = scratch("switch.csv");
  std::ofstream out(log);
  out << "time,x,y,steering,throttle,enable\n";
  for (int k = 0; k < 100; ++k) {
    out << 0.1 * k << ',' << k << ",1," << 0.3 * std::sin(0.1 * k) << ',' << 0.01 * k << ',';
    if (k % 10 == 0) out << (k < 50 ? 1 : 0);
    out << '\n';
  }
  out.close();
  const Guess guess = guess_map(read_delimited(log));
  EXPECT_EQ(find_pointer(guess.map, "/channels/d/formula")->text(), "if(hold(enable) > 0.5, throttle, 0)");
  const auto map = scratch("switch.json");
  std::ofstream(map) << to_json_text(guess.map);
  const Session s = read_session(log, load_log_map(map)).session;
  EXPECT_NEAR(s.command[37].d, 0.37, 1e-9);
  EXPECT_EQ(s.command[63].d, 0.0);
}

/// The map of a log with one steering column of this size.
Guess guess_of_steering(const std::string& name, const std::string& unit, double size) {
  const auto file = scratch("share.csv");
  std::ofstream out(file);
  out << "time,x,y," << name << "\ns,m,m," << unit << '\n';
  for (int k = 0; k < 200; ++k) out << 0.1 * k << ',' << k << ",1," << size * std::sin(0.1 * k) << '\n';
  out.close();
  return guess_map(read_delimited(file));
}

TEST(GuessCommands, AShareOfFullLockIsNoAngle) {
  const auto said = testing::Contains(
      testing::AllOf(testing::HasSubstr("share of full lock"), testing::HasSubstr("\"formula\": \"steering * LOCK\"")));
  for (const char* unit : {"", "1", "-", "norm", "normalised"}) {
    const Guess guess = guess_of_steering("steering", unit, 1.0);
    EXPECT_THAT(guess.remarks, said) << unit;
    EXPECT_EQ(find_pointer(guess.map, "/channels/delta/column")->text(), "steering") << unit;
  }
  EXPECT_THAT(guess_of_steering("steer_cmd", "", 0.9).remarks,
              testing::Contains(testing::HasSubstr("\"formula\": \"steer_cmd * LOCK\"")));
  EXPECT_THAT(guess_of_steering("steer_cmd_norm", "", 0.3).remarks,
              testing::Contains(testing::HasSubstr("share of full lock")));
  EXPECT_THAT(guess_of_steering("steering", "rad", 1.0).remarks, testing::Not(said));
  EXPECT_THAT(guess_of_steering("steering", "deg", 1.0).remarks, testing::Not(said));
  EXPECT_THAT(guess_of_steering("steering", "", 0.4).remarks, testing::Not(said)) << "a car's own angles";
  EXPECT_THAT(guess_of_steering("steering", "", 4.0).remarks, testing::Not(said));
  EXPECT_THAT(guess_of_steering("steering_angle", "", 1.0).remarks,
              testing::Not(testing::Contains(testing::HasSubstr("share of full lock"))));
}

/// Commands that a logger repeats in every second row are held until the next one.
TEST(GuessCommands, CommandsThatRepeatInStepAreHeld) {
  const auto hold = [](int rows, const char* channel) {
    const auto file = scratch("repeats.csv");
    std::ofstream out(file);
    out << "t_ms,x,y,yaw,throttle,steer_angle_rad\n";
    for (int k = 0; k < 2000; ++k) {
      const int given = k - k % rows;
      out << 10 * k << ',' << 0.05 * k << ",0,0," << 0.3 + 0.2 * std::sin(0.01 * given) << ','
          << 0.1 * std::sin(0.02 * given) << '\n';
    }
    out.close();
    const Guess guess = guess_map(read_delimited(file));
    const Node* const found = find_pointer(guess.map, std::string("/channels/") + channel + "/hold");
    return found == nullptr ? std::string() : found->text();
  };
  for (const char* channel : {"d", "delta"}) {
    EXPECT_EQ(hold(2, channel), "held") << channel;
    EXPECT_EQ(hold(1, channel), "") << channel;
  }
}

TEST(GuessCommands, AThrottleWithoutTheBrakeBesideItIsSaid) {
  EXPECT_THAT(guess_of_columns("time,x,y,delta,Gas,Bremse").remarks,
              testing::Contains(testing::AllOf(testing::HasSubstr("Bremse looks like a brake and is not used"),
                                               testing::HasSubstr("\"formula\": \"Gas - Bremse\""))));
}

/// The map of a log with a throttle in per cent and this brake, which reaches `most`.
Guess guess_of_brake(const std::string& name, const std::string& unit, double most) {
  const auto file = scratch("brake.csv");
  std::ofstream out(file);
  out << "time,x,y,delta,throttle," << name << "\ns,m,m,rad,%," << unit << '\n';
  for (int k = 0; k <= 100; ++k)
    out << 0.1 * k << ',' << k << ",1," << 0.1 * std::sin(0.1 * k) << ',' << k << ',' << 0.01 * k * most << '\n';
  out.close();
  return guess_map(read_delimited(file));
}
std::string formula_of_brake(const std::string& name, const std::string& unit, double most) {
  const Guess guess = guess_of_brake(name, unit, most);
  return find_pointer(guess.map, "/channels/d/formula")->text();
}

TEST(GuessCommands, ABrakeIsPerCentWhereUnitNameOrSizeSaysSo) {
  EXPECT_EQ(formula_of_brake("brake", "%", 56), "throttle / 100 - brake / 100");
  EXPECT_EQ(formula_of_brake("brake_pct", "", 56), "throttle / 100 - brake_pct / 100");
  EXPECT_EQ(formula_of_brake("brake", "", 99), "throttle / 100 - brake / 100");
  EXPECT_EQ(formula_of_brake("brake", "bar", 99), "throttle / 100 - brake / 99");
  EXPECT_EQ(formula_of_brake("BrakePresFront", "", 99), "throttle / 100 - BrakePresFront / 99");
  EXPECT_EQ(formula_of_brake("brake", "V", 5), "throttle / 100 - brake / 5");
  EXPECT_EQ(formula_of_brake("brake", "", 1), "throttle / 100 - brake");
}

TEST(GuessCommands, ABrakeThatMayBeAPressureIsSaid) {
  const Guess guess = guess_of_brake("brake", "", 56);
  EXPECT_EQ(find_pointer(guess.map, "/channels/d/formula")->text(), "throttle / 100 - brake / 56");
  const auto said = testing::AllOf(testing::HasSubstr("may be per cent or a pressure"),
                                   testing::HasSubstr("\"brake / 100\" if it is per cent"));
  EXPECT_THAT(guess.remarks, testing::Contains(said));
  EXPECT_THAT(find_pointer(guess.map, "/channels/d/note")->text(), said);
}

TEST(GuessCommands, AnUnusedBrakeIsScaledByItsUnit) {
  EXPECT_THAT(guess_of_brake("Bremse", "%", 70).remarks,
              testing::Contains(testing::HasSubstr("\"formula\": \"throttle / 100 - Bremse / 100\"")));
}

/// A log without a yaw rate, as of a compass or of a motion capture system.
TEST(GuessCommands, ASteeringThatIsPositiveToTheRightIsToldByTheHeading) {
  const auto sign = [](bool compass, double left) {
    const auto log = test::log_of("time,x,y,heading_deg,delta_rad", [&](std::ostream& out, double t, double x, double y,
                                                                        double yaw, double, double delta) {
      const double heading = std::remainder(compass ? pi / 2 - yaw : yaw, 2 * pi) * 180 / pi;
      out << t << ',' << x << ',' << y << ',' << heading << ',' << left * delta << '\n';
    });
    const auto guess = guess_map(read_delimited(log));
    const Node* const found = find_pointer(guess.map, "/channels/delta/sign");
    return found == nullptr ? 1.0 : found->number();
  };
  for (const bool compass : {false, true}) {
    EXPECT_EQ(sign(compass, -1.0), -1.0) << compass;
    EXPECT_EQ(sign(compass, 1.0), 1.0) << compass;
  }
}

TEST(GuessCommands, ASteeringAngleThatMayBeTheSteeringWheelsIsSaid) {
  const auto said = testing::Contains(testing::HasSubstr("if it is the steering wheel's, write \"formula\""));
  EXPECT_THAT(guess_of_columns("time,x,y,steering_angle_deg").remarks, said);
  EXPECT_THAT(guess_of_columns("time,x,y,delta_deg").remarks, testing::Not(said));
}

}  // namespace test_guess_commands
}  // namespace gripline::measured
