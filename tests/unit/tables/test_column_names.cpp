#include "tables/column_names.hpp"

#include <gtest/gtest.h>

namespace gripline {
namespace test_column_names {

TEST(ColumnNames, TheLastWordsOfAPathCount) {
  EXPECT_TRUE(is_called_in_path("pose.position.x", "positionx", "m"));
  EXPECT_TRUE(is_called_in_path("/odom/pose/pose/position/x", "positionx", "m"));
  EXPECT_TRUE(is_called_in_path("/car/state/speed_kmh", "speed", "m/s"));
  EXPECT_TRUE(is_called_in_path("cmd.steering_angle", "steeringangle", "rad"));
  EXPECT_TRUE(is_called_in_path("cmd.throttle", "throttle", "1"));
}

TEST(ColumnNames, ALetterAUnitAndWordsOfManyMeaningsDoNotCountAlone) {
  EXPECT_FALSE(is_called_in_path("pose.orientation.x", "x", "m"));
  EXPECT_FALSE(is_called_in_path("header.stamp.sec", "sec", "s"));
  EXPECT_FALSE(is_called_in_path("header.stamp.sec", "stamp", "s")) << "beside a nanosec";
  EXPECT_TRUE(is_called_in_path("odom.header.stamp", "stamp", "s"));
  EXPECT_FALSE(is_called_in_path("brake.pedal", "pedal", "1"));
  EXPECT_FALSE(is_called_in_path("g.long", "long", "rad"));
}

TEST(ColumnNames, WordsBeforeTheLastMakeItAnotherThing) {
  EXPECT_FALSE(is_called_in_path("accel.lat", "lat", "rad"));
  EXPECT_FALSE(is_called_in_path("gps.velocity.north", "north", "m"));
  EXPECT_FALSE(is_called_in_path("imu.angular_velocity.yaw", "yaw", "rad"));
  EXPECT_FALSE(is_called_in_path("motor.speed", "speed", "m/s"));
  EXPECT_TRUE(is_called_in_path("ekf.yaw", "yaw", "rad"));
}

TEST(ColumnNames, ASlashOrADotBesideABlankMakesNoPath) {
  EXPECT_FALSE(is_called_in_path("Latitude / Position", "position", "1"));
  EXPECT_FALSE(is_called_in_path("No. of throttle", "throttle", "1"));
  EXPECT_FALSE(is_called_in_path("throttle", "throttle", "1")) << "no path";
}

TEST(ColumnNames, WhatTheCarWasToldIsKnownByItsPath) {
  EXPECT_TRUE(is_path_of_command("/cmd_vel/linear/x"));
  EXPECT_TRUE(is_path_of_command("drive.speed"));
  EXPECT_TRUE(is_path_of_command("target.speed"));
  EXPECT_FALSE(is_path_of_command("odom.speed"));
  EXPECT_FALSE(is_path_of_command("cmd_speed")) << "no path";
}

TEST(ColumnNames, ACourseIsNoHeading) {
  for (const char* name : {"course", "GPS_Course_deg", "COG", "gps.course", "Course Over Ground"})
    EXPECT_TRUE(is_called_course(name)) << name;
  for (const char* name : {"heading", "yaw", "gps_heading_deg"}) EXPECT_FALSE(is_called_course(name)) << name;
}

TEST(ColumnNames, OnlyWhatStandsBehindTheWordIsItsUnit) {
  EXPECT_EQ(unit_behind("w_left_cm", "wleft", "m"), "cm");
  EXPECT_EQ(unit_behind("left", "left", "m"), "") << "not feet";
  EXPECT_EQ(unit_behind("X_FT", "x", "m"), "ft");
  EXPECT_EQ(unit_behind("pose.position.x_mm", "positionx", "m"), "mm");
  EXPECT_EQ(unit_behind("grade_deg", "grade", "rad"), "deg");
  EXPECT_EQ(unit_behind("grade_deg", "grade", "m"), "") << "of another kind";
  EXPECT_EQ(unit_behind("x_max", "x", "m"), "");
  EXPECT_EQ(unit_behind("y", "x", "m"), "");
}

}  // namespace test_column_names
}  // namespace gripline
