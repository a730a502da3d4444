#include "measured/session/guess_draft.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "config/json_file.hpp"
#include "measured/session/session_file.hpp"
#include "support/guess_of_columns.hpp"

namespace gripline::measured {
namespace test_guess_draft {

using test::guess_of_columns;
using testing_support::scratch;

/// As a recorder of a car's own bus writes it: dates, spelled-out units in capitals, two names in one.
TEST(GuessDraft, UnitsOfHeadersAreReadInAnyCaseAndSpelledOut) {
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
  EXPECT_THAT(guess.remarks, testing::Contains("Steering Angle: the header's \"furlongs\" is not a unit of this kind; "
                                               "taken for rad"));
  const auto map = scratch("bus.json");
  std::ofstream(map) << to_json_text(guess.map);
  EXPECT_NEAR(read_session(file, load_log_map(map)).session.at(40, 3), 24.9 * 0.44704, 1e-9);
}

TEST(GuessDraft, NamesMayEndWithAUnit) {
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
    const Guess guess = guess_of_columns(std::string("other,y,") + one.name);
    const std::string at = one.channel;
    ASSERT_NE(find_pointer(guess.map, at + "/column"), nullptr) << one.name;
    EXPECT_EQ(find_pointer(guess.map, at + "/column")->text(), one.name);
    EXPECT_EQ(find_pointer(guess.map, at + "/unit")->text(), one.unit) << one.name;
  }
}

TEST(GuessDraft, DegreeSignsOfWindows1252AreDegrees) {
  const Guess guess = guess_of_columns("Zeit [s],x [m],y [m],Gierrate [\xb0/s],Lenkwinkel [\xb0]");
  EXPECT_EQ(find_pointer(guess.map, "/channels/yaw_rate/unit")->text(), "deg/s");
  EXPECT_EQ(find_pointer(guess.map, "/channels/delta/unit")->text(), "deg");
}

/// The column of a channel, or the formula that has it; "" for neither.
std::string source_of(const Guess& guess, const std::string& channel) {
  for (const char* key : {"/column", "/formula"})
    if (const Node* const found = find_pointer(guess.map, "/channels/" + channel + key)) return found->text();
  return "";
}

TEST(GuessDraft, WordsOfAPathCount) {
  const Guess guess = guess_of_columns(
      "stamp,pose.position.x,pose.position.y,twist.linear.x,twist.linear.y,twist.angular.z,cmd.throttle,"
      "cmd.steering_angle");
  EXPECT_THAT(guess.open, testing::IsEmpty());
  EXPECT_EQ(source_of(guess, "x"), "pose.position.x");
  EXPECT_EQ(source_of(guess, "y"), "pose.position.y");
  EXPECT_EQ(source_of(guess, "vx"), "twist.linear.x");
  EXPECT_EQ(source_of(guess, "vy"), "twist.linear.y");
  EXPECT_EQ(source_of(guess, "yaw_rate"), "twist.angular.z");
  EXPECT_THAT(source_of(guess, "delta"), testing::HasSubstr("`cmd.steering_angle`"));
  EXPECT_THAT(source_of(guess, "d"), testing::HasSubstr("`cmd.throttle`"));
}

TEST(GuessDraft, OfPathsACommandIsNoReadingAndIsTakenFirstForACommand) {
  const Guess guess = guess_of_columns("time,x,y,drive.speed,odom.speed,state.steering_angle,drive.steering_angle");
  EXPECT_EQ(source_of(guess, "vx"), "odom.speed");
  EXPECT_THAT(source_of(guess, "delta"), testing::HasSubstr("`drive.steering_angle`"));
}

/// The column of a channel, "" for none, in a log in which u is 10 and v swings by `sideways` about `middle`.
std::string column_beside_u(const char* channel, double middle, double sideways) {
  const auto file = scratch("body.csv");
  std::ofstream out(file);
  out << "time,x,y,delta,u_mps,v_mps\n";
  for (int k = 0; k < 200; ++k)
    out << 0.1 * k << ',' << k << ",1,0.1," << 10 + 0.001 * k << ',' << middle + (k % 2 == 0 ? 1 : -1) * sideways
        << '\n';
  out.close();
  const Guess guess = guess_map(read_delimited(file));
  const Node* const found = find_pointer(guess.map, std::string("/channels/") + channel + "/column");
  return found == nullptr ? std::string() : found->text();
}

TEST(GuessDraft, UIsForwardAndVLateralWhereBothAreThere) {
  EXPECT_EQ(column_beside_u("vx", 0.0, 0.5), "u_mps");
  EXPECT_EQ(column_beside_u("vy", 0.0, 0.5), "v_mps");
  EXPECT_EQ(column_beside_u("vx", 12.0, 0.5), "v_mps") << "u is an input of a car that goes at v";
  EXPECT_EQ(column_beside_u("vy", 12.0, 0.5), "");
}

}  // namespace test_guess_draft
}  // namespace gripline::measured
