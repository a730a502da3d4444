#include "measured/session/log_guess.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string>

#include "config/errors.hpp"
#include "config/json_file.hpp"
#include "measured/session/session_checks.hpp"
#include "measured/session/session_file.hpp"
#include "support/guess_of_columns.hpp"

namespace gripline::measured {
namespace test_log_guess {

using test::guess_of_columns;
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

TEST(LogGuess, DatesOfWholeSecondsAreNoMilliseconds) {
  const auto file = scratch("whole.csv");
  std::ofstream out(file);
  out << "time,x,y,delta\n";
  for (int k = 0; k < 100; ++k) out << "2018-04-08 10:31:" << 10 + k / 10 << ',' << k << ",1,0.1\n";
  out.close();
  const Guess guess = guess_map(read_delimited(file));
  EXPECT_EQ(find_pointer(guess.map, "/time/unit")->text(), "s");
}

TEST(LogGuess, ColumnsThatNothingUsesAreNamed) {
  EXPECT_THAT(guess_of_columns("time,x,y,delta,throttle,oil,Water Temperature").remarks,
              testing::Contains("columns not used: oil, Water Temperature"));
  EXPECT_THAT(guess_of_columns("time,x,y,delta,throttle,brake,rot").remarks, testing::Contains("columns not used: rot"))
      << "three letters of the throttle";
  EXPECT_THAT(guess_of_columns("time,x,y,delta,throttle,brake").remarks,
              testing::Not(testing::Contains(testing::HasSubstr("not used"))));
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
