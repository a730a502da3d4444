#include "measured/session/log_guess.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

#include "config/errors.hpp"
#include "config/json_file.hpp"
#include "measured/session/session_checks.hpp"
#include "measured/session/session_file.hpp"
#include "support/scratch.hpp"

namespace gripline::measured {
namespace test_log_guess {

using testing_support::scratch;
constexpr double pi = std::numbers::pi;

/// A weaving car as a logger for the street would write it: compass, km/h, per cent, steering wheel, milliseconds.
std::filesystem::path street_log() {
  const auto file = scratch("street.csv");
  std::ofstream out(file);
  out.precision(12);
  out << "Recorded;by hand\n\nTime;East;North;Heading;Speed;Gyro Z;Throttle Pos;Brake Pressure;Steering Angle\n"
         "ms;m;m;deg;km/h;deg/s;%;kPa;deg\n";
  double x = 0, y = 0, yaw = 0;
  for (int k = 0; k < 2000; ++k) {
    const double t = 0.05 * k, rate = 0.5 * std::sin(0.7 * t), v = 12 + 3 * std::sin(0.2 * t);
    const double brake = std::sin(0.2 * t) < -0.9 ? 800 : 0;
    out << 50 * k << ';' << x << ';' << y << ';' << std::fmod(720000 + 90 - yaw * 180 / pi, 360) << ';' << 3.6 * v
        << ';' << rate * 180 / pi << ';' << 20 + k % 7 << ';' << brake << ';'
        << -15 * std::atan(2.6 * rate / v) * 180 / pi << '\n';
    x += 0.05 * v * std::cos(yaw + 0.025 * rate);
    y += 0.05 * v * std::sin(yaw + 0.025 * rate);
    yaw += 0.05 * rate;
  }
  return file;
}

TEST(LogGuess, ItsMapReadsTheLogItWasMadeFrom) {
  const auto log = street_log();
  const Guess guess = guess_map(read_delimited(log));
  const auto file = scratch("guess.json");
  std::ofstream(file) << to_json_text(guess.map);
  const LogMap map = load_log_map(file);
  const SessionFile session = read_session(log, map);
  check_session(session, 12.0);  // throws when a unit, a sign or the compass was taken wrongly
  const Session& s = session.session;
  EXPECT_NEAR(s.t[20], 1.0, 1e-9);
  EXPECT_NEAR(s.at(40, 3), 12 + 3 * std::sin(0.4), 1e-6);
  EXPECT_NEAR(s.at(40, 5), 0.5 * std::sin(1.4), 1e-6);
  EXPECT_NEAR(s.command[40].delta, std::atan(2.6 * s.at(40, 5) / s.at(40, 3)), 1e-6);
  EXPECT_NEAR(s.command[40].d, 0.25, 1e-9);
  EXPECT_FALSE(map.delay(3).has_value());  // to be found
  const auto said = [&](const char* words) {
    return std::any_of(guess.remarks.begin(), guess.remarks.end(),
                       [&](const std::string& r) { return r.find(words) != std::string::npos; });
  };
  EXPECT_TRUE(said("counts clockwise"));
  EXPECT_TRUE(said("steering wheel"));
  EXPECT_TRUE(said("positive to the right"));
  EXPECT_TRUE(said("largest value"));
}

/// Radians that count on over turns look as large as degrees; the path tells them apart.
TEST(LogGuess, RadiansThatCountOnOverTurnsAreNoDegrees) {
  const auto log = scratch("circles.csv");
  std::ofstream out(log);
  out.precision(12);
  out << "t,x,y,yaw,vx,yaw_rate,throttle,steering\n";
  for (int k = 0; k < 2000; ++k) {
    const double yaw = 0.025 * k;  // eight turns
    out << 0.05 * k << ',' << 20 * std::sin(yaw) << ',' << -20 * std::cos(yaw) << ',' << yaw << ",10,0.5,0.2,0.13\n";
  }
  out.close();
  const Guess guess = guess_map(read_delimited(log));
  const auto file = scratch("circles.json");
  std::ofstream(file) << to_json_text(guess.map);
  const SessionFile session = read_session(log, load_log_map(file));
  EXPECT_NEAR(session.session.at(100, 2), 2.5, 1e-9);
  EXPECT_NEAR(session.session.at(1000, 2), 25.0, 1e-9);
}

TEST(LogGuess, WhatCannotBeGuessedIsLeftOpenWithTheColumnsThereAre) {
  const auto file = scratch("odd.csv");
  std::ofstream(file) << "a,b,c\n1,2,7\n2,3,7\n3,1,7\n4,5,7\n";
  const Guess guess = guess_map(read_delimited(file));
  EXPECT_THAT(guess.open, testing::ElementsAre("delta", "vx", "yaw_rate", "time"));
  EXPECT_EQ(find_pointer(guess.map, "/channels/delta/column")->text(), "?");
  // Time only rises, and what never changes is none of them.
  EXPECT_THAT(find_pointer(guess.map, "/channels/delta/note")->text(), testing::EndsWith("a (1 to 4), b (1 to 5)"));
  EXPECT_THAT(find_pointer(guess.map, "/time/note")->text(), testing::EndsWith("one of: a (1 to 4)"));
  std::ofstream(scratch("open.json")) << to_json_text(guess.map);
  try {
    load_log_map(scratch("open.json"));
    FAIL();
  } catch (const InputError& e) {
    for (const char* channel : {"/time/column", "/channels/delta/column", "/channels/vx/column"})
      EXPECT_THAT(e.what(), testing::HasSubstr(channel));
  }
}

/// As a recorder of a car's own bus writes it: dates, spelled-out units in capitals, two names in one.
TEST(LogGuess, UnitsOfHeadersAreReadInAnyCaseAndSpelledOut) {
  const auto file = scratch("bus.csv");
  std::ofstream out(file);
  out.precision(9);
  out << "Time,Latitude / Y Position (Degrees),Longitude / X Position (Degrees),Speed (MPH),Steering Angle "
         "(furlongs)\n";
  for (int k = 0; k < 100; ++k)
    out << "2018-04-08 10:31:" << 10 + k / 10 << '.' << k % 10 << ',' << 30.0 + 1e-5 * k << ",-97.7," << 24.9 << ','
        << 0.1 << '\n';
  out.close();
  const Guess guess = guess_map(read_delimited(file));
  EXPECT_THAT(guess.open, testing::IsEmpty());
  EXPECT_EQ(find_pointer(guess.map, "/time/column")->text(), "Time");
  EXPECT_EQ(find_pointer(guess.map, "/channels/latitude/column")->text(), "Latitude / Y Position");
  EXPECT_EQ(find_pointer(guess.map, "/channels/vx/unit")->text(), "mph");
  EXPECT_THAT(guess.remarks, testing::Contains("Steering Angle: the header's \"furlongs\" is no unit of this kind; "
                                               "taken for rad"));
  const auto map = scratch("bus.json");
  std::ofstream(map) << to_json_text(guess.map);
  EXPECT_NEAR(read_session(file, load_log_map(map)).session.at(40, 3), 24.9 * 0.44704, 1e-9);
}

/// The guess for a straight drive at 10 m/s whose speed is `factor` times that, under this header.
Guess guess_of_speed(const std::string& header, double factor) {
  const auto file = scratch("speed.csv");
  std::ofstream out(file);
  out.precision(12);
  out << "time,x,y,delta," << header << '\n';
  for (int k = 0; k < 400; ++k) out << 0.1 * k << ',' << k << ",1,0.1," << 10 * factor << '\n';
  out.close();
  return guess_map(read_delimited(file));
}

TEST(LogGuess, UnitsOfSpeedNearEachOtherAreToldApart) {
  const auto unit = [](const std::string& header, double factor) {
    return find_pointer(guess_of_speed(header, factor).map, "/channels/vx/unit")->text();
  };
  EXPECT_EQ(unit("speed", 3600.0 / 1852.0), "kn");
  EXPECT_EQ(unit("speed", 1 / 0.44704), "mph");
  EXPECT_EQ(unit("speed", 1 / 0.3048), "ft/s");
  EXPECT_EQ(unit("speed", 3.6), "km/h");
  EXPECT_EQ(unit("speed", 2.7), "m/s");
  EXPECT_THAT(guess_of_speed("speed", 2.7).remarks, testing::Contains(testing::HasSubstr("its unit is not told")));
  EXPECT_THAT(guess_of_speed("speed", 1.0).remarks, testing::Not(testing::Contains(testing::HasSubstr("vx:"))));
  for (const char* header : {"speed (knots)", "speed (kts)", "speed [kn]", "speed_knots"})
    EXPECT_EQ(unit(header, 3600.0 / 1852.0), "kn") << header;
}

TEST(LogGuess, DatesOfWholeSecondsAreNoMilliseconds) {
  const auto file = scratch("whole.csv");
  std::ofstream out(file);
  out << "time,x,y,delta\n";
  for (int k = 0; k < 100; ++k) out << "2018-04-08 10:31:" << 10 + k / 10 << ',' << k << ",1,0.1\n";
  out.close();
  EXPECT_EQ(find_pointer(guess_map(read_delimited(file)).map, "/time/unit")->text(), "s");
}

TEST(LogGuess, AnAngleOfTheSteeringWheelIsToldByItsName) {
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
TEST(LogGuess, ASwitchOfTheDriveHoldsUntilItIsReadAgain) {
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

TEST(LogGuess, AShareOfFullLockIsNoAngle) {
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
TEST(LogGuess, CommandsThatRepeatInStepAreHeld) {
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

/// A receiver of 1 Hz in rows of 20 Hz: ten rows after a new place the next one may not be there yet.
Guess guess_of_held_place(const std::string& speed, double factor, int rows) {
  const auto file = scratch("held.csv");
  std::ofstream out(file);
  out.precision(12);
  out << "time,x,y,delta," << speed << '\n';
  for (int k = 0; k < rows; ++k) {
    const double t = 0.05 * k, v = 10 + 2 * std::sin(0.3 * t), now = std::floor(t);
    out << t << ',' << 10 * now + 2 / 0.3 * (1 - std::cos(0.3 * now)) << ",1,0.1," << v * factor << '\n';
  }
  out.close();
  return guess_map(read_delimited(file));
}

TEST(LogGuess, UnitsOfSpeedAreToldByPlacesThatRepeat) {
  for (const auto& [unit, factor] : {std::pair("km/h", 3.6), {"kn", 3600.0 / 1852.0}, {"m/s", 1.0}})
    EXPECT_EQ(find_pointer(guess_of_held_place("speed", factor, 1200).map, "/channels/vx/unit")->text(), unit);
  EXPECT_THAT(guess_of_held_place("speed", 3.6, 300).remarks,
              testing::Contains(testing::HasSubstr("the place tells none")));
}

TEST(LogGuess, TheUnitOfANameStandsAndWhatThePathSaysIsTold) {
  const auto said = testing::Contains(testing::HasSubstr("looks like km/h; its name says m/s"));
  const Guess wrong = guess_of_held_place("speed_mps", 3.6, 1200);
  EXPECT_EQ(find_pointer(wrong.map, "/channels/vx/unit")->text(), "m/s");
  EXPECT_THAT(wrong.remarks, said);
  EXPECT_THAT(guess_of_held_place("speed_kmh", 3.6, 1200).remarks,
              testing::Not(testing::Contains(testing::HasSubstr("vx:"))));
}

/// The map of a log of these columns, each with the values 0, 0.01, 0.02 and so on.
Guess guess_of_columns(const std::string& header) {
  const auto file = scratch("columns.csv");
  std::ofstream out(file);
  out << header << '\n';
  const auto columns = std::count(header.begin(), header.end(), ',') + 1;
  for (int k = 0; k < 100; ++k)
    for (int c = 0; c < columns; ++c) out << 0.01 * k << (c + 1 < columns ? ',' : '\n');
  out.close();
  return guess_map(read_delimited(file));
}

TEST(LogGuess, NamesMayEndWithAUnit) {
  struct Case {
    const char *name, *channel, *unit;
  };
  for (const Case& one : {Case{"speed_kmh", "/channels/vx", "km/h"},
                          {"speed_kph", "/channels/vx", "km/h"},
                          {"vehicle_speed_kmh", "/channels/vx", "km/h"},
                          {"speed_ms", "/channels/vx", "m/s"},
                          {"yaw_rate_dps", "/channels/yaw_rate", "deg/s"},
                          {"yawrate_dps", "/channels/yaw_rate", "deg/s"},
                          {"yaw_rate_deg_s", "/channels/yaw_rate", "deg/s"},
                          {"yaw_rate_rads", "/channels/yaw_rate", "rad/s"},
                          {"yaw_rate_radps", "/channels/yaw_rate", "rad/s"},
                          {"steer_deg", "/channels/delta", "deg"},
                          {"steering_angle_deg", "/channels/delta", "deg"},
                          {"timestamp_ms", "/time", "ms"},
                          {"t_ms", "/time", "ms"},
                          {"East_m", "/channels/x", "m"},
                          {"x_mm", "/channels/x", "mm"}}) {
    const Guess guess = guess_of_columns(std::string("other,") + one.name);
    const std::string at = one.channel;
    ASSERT_NE(find_pointer(guess.map, at + "/column"), nullptr) << one.name;
    EXPECT_EQ(find_pointer(guess.map, at + "/column")->text(), one.name);
    EXPECT_EQ(find_pointer(guess.map, at + "/unit")->text(), one.unit) << one.name;
  }
}

TEST(LogGuess, ColumnsThatNothingUsesAreNamed) {
  EXPECT_THAT(guess_of_columns("time,x,y,delta,throttle,oil,Water Temperature").remarks,
              testing::Contains("columns not used: oil, Water Temperature"));
  EXPECT_THAT(guess_of_columns("time,x,y,delta,throttle,brake").remarks,
              testing::Not(testing::Contains(testing::HasSubstr("not used"))));
}

TEST(LogGuess, AThrottleWithoutTheBrakeBesideItIsSaid) {
  EXPECT_THAT(guess_of_columns("time,x,y,delta,Gas,Bremse").remarks,
              testing::Contains(testing::AllOf(testing::HasSubstr("Bremse looks like a brake and is not used"),
                                               testing::HasSubstr("\"formula\": \"Gas - Bremse\""))));
}

TEST(LogGuess, ASteeringAngleThatMayBeTheSteeringWheelsIsSaid) {
  const auto said = testing::Contains(testing::HasSubstr("if it is the steering wheel's, write \"formula\""));
  EXPECT_THAT(guess_of_columns("time,x,y,steering_angle_deg").remarks, said);
  EXPECT_THAT(guess_of_columns("time,x,y,delta_deg").remarks, testing::Not(said));
}

TEST(LogGuess, StepsOfOneAreSecondsOrMilliseconds) {
  const auto file = scratch("one.csv");
  std::ofstream out(file);
  out << "time,x,y,delta\n";
  for (int k = 0; k < 100; ++k) out << k << ',' << k << ",1,0.1\n";
  out.close();
  const Guess guess = guess_map(read_delimited(file));
  EXPECT_EQ(find_pointer(guess.map, "/time/unit")->text(), "s");
  EXPECT_THAT(guess.remarks, testing::Contains(testing::HasSubstr("1 Hz in s and 1000 Hz in ms")));
}

}  // namespace test_log_guess
}  // namespace gripline::measured
