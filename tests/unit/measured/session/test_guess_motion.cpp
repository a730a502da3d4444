#include "measured/session/guess_motion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <string>
#include <utility>

#include "config/json_file.hpp"
#include "measured/session/log_guess.hpp"
#include "measured/session/session_file.hpp"
#include "support/guess_of_columns.hpp"
#include "support/scratch.hpp"
#include "support/session_logs.hpp"

namespace gripline::measured {
namespace test_guess_motion {

using testing_support::scratch;

/// Radians that count on over turns look as large as degrees; the path tells them apart.
TEST(GuessMotion, RadiansThatCountOnOverTurnsAreNoDegrees) {
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

/// A map that names one of x and y alone would be refused.
TEST(GuessMotion, AnXWithoutAYIsNoPlace) {
  for (const char* const header : {"t,x,latitude,longitude,steering", "t,y,latitude,longitude,steering"}) {
    const Guess guess = test::guess_of_columns(header);
    const auto file = scratch("one.json");
    std::ofstream(file) << to_json_text(guess.map);
    const LogMap map = load_log_map(file);
    EXPECT_FALSE(map[Source::x] || map[Source::y]) << header;
    EXPECT_TRUE(map[Source::latitude] && map[Source::longitude]) << header;
    EXPECT_THAT(guess.remarks, testing::Contains(testing::StartsWith("columns not used: "))) << header;
  }
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

TEST(GuessMotion, UnitsOfSpeedNearEachOtherAreDistinguished) {
  const auto unit = [](const std::string& header, double factor) {
    const Guess guess = guess_of_speed(header, factor);
    return find_pointer(guess.map, "/channels/vx/unit")->text();
  };
  EXPECT_EQ(unit("speed", 3600.0 / 1852.0), "kn");
  EXPECT_EQ(unit("speed", 1 / 0.44704), "mph");
  EXPECT_EQ(unit("speed", 1 / 0.3048), "ft/s");
  EXPECT_EQ(unit("speed", 3.6), "km/h");
  EXPECT_EQ(unit("speed", 2.7), "m/s");
  EXPECT_THAT(guess_of_speed("speed", 2.7).remarks,
              testing::Contains(testing::HasSubstr("this does not identify its unit")));
  EXPECT_THAT(guess_of_speed("speed", 1.0).remarks, testing::Not(testing::Contains(testing::HasSubstr("vx:"))));
  for (const char* header : {"speed (knots)", "speed (kts)", "speed [kn]", "speed_knots"})
    EXPECT_EQ(unit(header, 3600.0 / 1852.0), "kn") << header;
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

TEST(GuessMotion, UnitsOfSpeedAreIdentifiedByPlacesThatRepeat) {
  for (const auto& [unit, factor] : {std::pair("km/h", 3.6), {"kn", 3600.0 / 1852.0}, {"m/s", 1.0}}) {
    const Guess guess = guess_of_held_place("speed", factor, 1200);
    EXPECT_EQ(find_pointer(guess.map, "/channels/vx/unit")->text(), unit);
  }
  EXPECT_THAT(guess_of_held_place("speed", 3.6, 300).remarks,
              testing::Contains(testing::HasSubstr("the place identifies none")));
}

TEST(GuessMotion, TheUnitOfANameStandsAndWhatThePathSaysIsTold) {
  const auto said = testing::Contains(testing::HasSubstr("looks like km/h; its name says m/s"));
  const Guess wrong = guess_of_held_place("speed_mps", 3.6, 1200);
  EXPECT_EQ(find_pointer(wrong.map, "/channels/vx/unit")->text(), "m/s");
  EXPECT_THAT(wrong.remarks, said);
  EXPECT_THAT(guess_of_held_place("speed_kmh", 3.6, 1200).remarks,
              testing::Not(testing::Contains(testing::HasSubstr("vx:"))));
}

TEST(GuessMotion, ACourseIsNoYawWhereThereIsAPlace) {
  const auto said = [](const char* end) {
    return testing::Contains(
        testing::AllOf(testing::HasSubstr("GPS_Course_deg is the course of the velocity"), testing::HasSubstr(end)));
  };
  const Guess beside = test::guess_of_columns("time,x,y,delta,GPS_Course_deg");
  EXPECT_EQ(find_pointer(beside.map, "/channels/yaw"), nullptr);
  EXPECT_THAT(beside.remarks, said("not used"));
  const Guess alone = test::guess_of_columns("time,vx,delta,GPS_Course_deg");
  EXPECT_EQ(find_pointer(alone.map, "/channels/yaw/column")->text(), "GPS_Course_deg");
  EXPECT_THAT(alone.remarks, said("taken in its place"));
  EXPECT_THAT(test::guess_of_columns("time,x,y,delta,yaw,GPS_Course_deg").remarks,
              testing::Not(testing::Contains(testing::HasSubstr("course of the velocity"))));
}

TEST(GuessMotion, AHeadingGoesBeforeACourse) {
  const auto yaw_of = [](const char* columns) {
    const Guess guess = test::guess_of_columns(columns);
    const Node* const yaw = find_pointer(guess.map, "/channels/yaw");
    return yaw == nullptr ? std::string() : to_json_text(*yaw);
  };
  EXPECT_THAT(yaw_of("time,pose.position.x,pose.position.y,delta,imu.yaw,course"), testing::HasSubstr("imu.yaw"));
  EXPECT_THAT(yaw_of("time,vx,delta,course,pose.orientation.z,pose.orientation.w"),
              testing::HasSubstr("pose.orientation.z"));
  EXPECT_THAT(yaw_of("time,vx,delta,course,goal.pose.orientation.z,goal.pose.orientation.w"),
              testing::HasSubstr("course"));
}

TEST(GuessMotion, AQuaternionIsAYaw) {
  const auto log =
      test::log_of("time,pose.position.x,pose.position.y,pose.orientation.z,pose.orientation.w,steering_angle",
                   [](std::ostream& out, double t, double x, double y, double yaw, double, double delta) {
                     out << t << ',' << x << ',' << y << ',' << std::sin(0.5 * yaw) << ',' << std::cos(0.5 * yaw) << ','
                         << delta << '\n';
                   });
  const Guess guess = guess_map(read_delimited(log));
  EXPECT_EQ(find_pointer(guess.map, "/channels/yaw/formula")->text(),
            "2 * atan2(`pose.orientation.z`, `pose.orientation.w`)");
}

/// As aircraft and ships count: x to the north, y to the east, all positive to the right.
TEST(GuessMotion, OfAFrameThatIsPositiveToTheRightSignsAreTurned) {
  const auto log =
      test::log_of("time,north_m,east_m,heading_rad,u_mps,v_mps,r_radps,steer_rad",
                   [](std::ostream& out, double t, double x, double y, double yaw, double rate, double delta) {
                     const double heading = std::remainder(std::numbers::pi / 2 - yaw, 2 * std::numbers::pi);
                     out << t << ',' << y << ',' << x << ',' << heading << ",10," << -0.1 * rate << ',' << -rate << ','
                         << -delta << '\n';
                   });
  const Guess guess = guess_map(read_delimited(log));
  EXPECT_EQ(find_pointer(guess.map, "/channels/vx/column")->text(), "u_mps");
  for (const char* turned : {"/channels/vy", "/channels/yaw_rate", "/channels/delta"}) {
    const Node* const sign = find_pointer(guess.map, std::string(turned) + "/sign");
    ASSERT_NE(sign, nullptr) << turned;
    EXPECT_EQ(sign->number(), -1.0) << turned;
  }
}

TEST(GuessMotion, ReadingsThatRepeatInStepAreHeld) {
  const auto file = scratch("repeats.csv");
  std::ofstream out(file);
  out << "time,x,y,vx,yaw_rate,delta\n";
  for (int k = 0; k < 1000; ++k) {
    const double t = 0.02 * k, read = 0.1 * (k / 5);  // a receiver of 10 Hz
    out << t << ',' << 10 * read << ',' << std::sin(read) << ',' << 10 + std::sin(0.5 * read) << ','
        << 0.2 * std::sin(t) << ',' << 0.1 * std::sin(t) << '\n';
  }
  out.close();
  const Guess guess = guess_map(read_delimited(file));
  for (const char* channel : {"x", "y", "vx"}) {
    const Node* const hold = find_pointer(guess.map, std::string("/channels/") + channel + "/hold");
    ASSERT_NE(hold, nullptr) << channel;
    EXPECT_EQ(hold->text(), "held") << channel;
  }
  EXPECT_EQ(find_pointer(guess.map, "/channels/yaw_rate/hold"), nullptr);
  EXPECT_THAT(guess.remarks, testing::Contains("x: a new value every 5 rows; read when it is new"));
}

}  // namespace test_guess_motion
}  // namespace gripline::measured
