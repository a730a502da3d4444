#include "bags/message_schema.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "config/errors.hpp"
#include "support/bag_writing.hpp"
#include "support/scratch.hpp"

namespace gripline::bags {
namespace test_message_schema {

using testing::ElementsAre;
using testing::HasSubstr;
using testing_support::rule;

Schema parsed(const std::string& text, Wire wire = Wire::ros1, const Definitions& others = {}) {
  return parse_schema("car_msgs/State", text, wire, others);
}

std::string why(const std::string& text, Wire wire = Wire::ros1, const Definitions& others = {}) {
  try {
    parsed(text, wire, others);
  } catch (const InputError& e) {
    return e.what();
  }
  return "fine";
}

TEST(MessageSchema, ReadsFieldsArraysConstantsAndComments) {
  const Schema s = parsed(
      "# a car\nint32 MODE=3\nstring NAME = sharp # not a comment\nuint8 gear  # which\nfloat32[4] wheel\n"
      "float64[] slip\nfloat64[<=3] few\nstring<=10 label\n\ntime stamp\n",
      Wire::ros1);
  ASSERT_EQ(s.root().fields.size(), 6u);
  const auto& f = s.root().fields;
  EXPECT_EQ(f[0].name, "gear");
  EXPECT_EQ(f[0].kind, Kind::uint8);
  EXPECT_EQ(f[1].many, Field::Many::fixed);
  EXPECT_EQ(f[1].count, 4u);
  EXPECT_EQ(f[2].many, Field::Many::variable);
  EXPECT_EQ(f[3].many, Field::Many::variable);
  EXPECT_EQ(f[4].kind, Kind::text);
  EXPECT_EQ(f[5].kind, Kind::time);
  EXPECT_EQ(s.root().least_bytes, 1u + 16 + 4 + 4 + 4 + 8);
}

TEST(MessageSchema, TypesOfTheSamePackageOfOthersAndHeadersAreFound) {
  const Schema s = parse_schema("nav_msgs/Odometry", testing_support::odometry_text(), Wire::ros1, {});
  EXPECT_THAT(
      number_paths(s, 0, 100),
      ElementsAre("header.seq", "header.stamp", "pose.pose.position.x", "pose.pose.position.y", "pose.pose.position.z",
                  "pose.pose.orientation.x", "pose.pose.orientation.y", "pose.pose.orientation.z",
                  "pose.pose.orientation.w", "twist.twist.linear.x", "twist.twist.linear.y", "twist.twist.linear.z",
                  "twist.twist.angular.x", "twist.twist.angular.y", "twist.twist.angular.z"));
  EXPECT_EQ(number_paths(s, 36, 20).size(), 20u) << "no more than asked for";
}

/// ROS 2 writes types with "msg" between, and its header has no number; definitions of ROS 1 serve for it.
TEST(MessageSchema, CommonDefinitionsServeRosTwo) {
  for (const auto& [type, text] : common_definitions())
    EXPECT_NO_THROW(parse_schema(type, text, Wire::cdr, common_definitions())) << type;
  const Definitions one = {{"std_msgs/Header", testing_support::header_text}};
  const Schema s = parsed("std_msgs/msg/Header header\nbuiltin_interfaces/msg/Time at\n", Wire::cdr, one);
  EXPECT_THAT(number_paths(s, 0, 10), ElementsAre("header.stamp", "at"));
  EXPECT_EQ(short_type("nav_msgs/msg/Odometry"), "nav_msgs/Odometry");
}

TEST(MessageSchema, APackageOfRosTwoMayHaveAHeaderOfItsOwn) {
  const std::string text = "Header header\n================\nMSG: car_msgs/Header\nfloat64 a\nfloat64 b\n";
  const Schema own = parse_schema("car_msgs/A", text, Wire::cdr, common_definitions());
  EXPECT_EQ(own.types.back().name, "car_msgs/Header");
  const Schema common = parse_schema("car_msgs/A", "Header header\n", Wire::cdr, common_definitions());
  EXPECT_EQ(common.types.back().name, "std_msgs/Header");
  // Common definitions serve ROS 1 too, whose header begins with a number more.
  const Schema first = parse_schema("car_msgs/A", "Header header\n", Wire::ros1, common_definitions());
  EXPECT_EQ(first.types.back().fields.front().name, "seq");
}

TEST(MessageSchema, AnEmptyMessageIsOneByteInRosTwoAndNoneInRosOne) {
  EXPECT_EQ(parsed("int8 A=1\n", Wire::cdr).root().least_bytes, 1u);
  EXPECT_EQ(parsed("int8 A=1\n", Wire::ros1).root().least_bytes, 0u);
}

TEST(MessageSchema, WhatCannotBeReadIsSaid) {
  EXPECT_THAT(why("Wheel front\n"), HasSubstr("type car_msgs/Wheel, which car_msgs/State holds, is not defined"));
  EXPECT_THAT(why("State again\n"), HasSubstr("type car_msgs/State holds itself"));
  EXPECT_THAT(why("float64\n"),
              HasSubstr("definition of car_msgs/State, line 1, \"float64\": expected a type and a name"));
  EXPECT_THAT(why("float64[four] a\n"), HasSubstr("expected a number of elements"));
  EXPECT_THAT(why(std::string("Wheel a\n") + rule + "MSG: car_msgs/Wheel\nState of\n"), HasSubstr("holds itself"));
}

/// Ten members of ten members, twenty deep, and not a number in them.
TEST(MessageSchema, TypesThatNestForeverAreLookedAtForAWhileOnly) {
  std::string text;
  for (int k = 0; k < 10; ++k) text += "L0 m" + std::to_string(k) + "\n";
  for (int level = 0; level < 20; ++level) {
    text += std::string(rule) + "MSG: car_msgs/L" + std::to_string(level) + "\n";
    for (int k = 0; k < 10; ++k)
      text += (level == 19 ? std::string("string") : "L" + std::to_string(level + 1)) + " m" + std::to_string(k) + "\n";
  }
  const Schema s = parsed(text);
  EXPECT_TRUE(number_paths(s, 3, 50).empty());
  EXPECT_GT(s.root().least_bytes, std::uint64_t{1} << 39U) << "limited, not wrapped around";
}

TEST(MessageSchema, AFolderOfDefinitionsNamesTypesByPackage) {
  const auto folder = testing_support::scratch("msgs");
  std::filesystem::create_directories(folder / "car_msgs/msg");
  std::filesystem::create_directories(folder / "other_msgs");
  std::ofstream(folder / "car_msgs/msg/Wheel.msg") << "float64 slip\n";
  std::ofstream(folder / "other_msgs/Gear.msg") << "uint8 gear\n";
  const Definitions all = definitions_in(folder);
  EXPECT_EQ(all.at("car_msgs/Wheel"), "float64 slip\n");
  EXPECT_THAT(number_paths(parsed("Wheel w\nother_msgs/Gear g\n", Wire::cdr, all), 0, 10),
              ElementsAre("w.slip", "g.gear"));
  EXPECT_THROW(definitions_in(folder / "nowhere"), InputError);
}

}  // namespace test_message_schema
}  // namespace gripline::bags
