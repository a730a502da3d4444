#include "measured/session/log_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <numbers>

#include "config/errors.hpp"
#include "support/scratch.hpp"

namespace gripline::measured {
namespace test_log_map {

using testing::AllOf;
using testing::HasSubstr;

/// A map with these members of its channels beside those that every map needs.
LogMap map_of(const std::string& members, const std::string& time = R"("t")") {
  const auto file = testing_support::scratch("map.json");
  std::ofstream(file) << R"({"time": )" << time << R"(, "channels": {"yaw": "psi", "delta": {"column": "steer"})"
                      << members << "}}";
  return load_log_map(file);
}

std::string why(const std::string& members, const std::string& time = R"("t")") {
  try {
    map_of(members, time);
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}

TEST(LogMap, AxesOfTheVelocityLieAlongTheCar) {
  const auto turned = [](const char* yaw) {
    return std::string(R"(, "vy": "b", "vx": {"column": "a", "frame": {"yaw": ")") + yaw + R"("}})";
  };
  EXPECT_EQ(map_of(turned("180 deg")).velocity.yaw, std::numbers::pi);
  EXPECT_EQ(why(turned("-59 deg")), "accepted");
  EXPECT_THAT(why(turned("-90 deg")), AllOf(HasSubstr("/channels/vx/frame/yaw"), HasSubstr("-B and A")));
}

TEST(LogMap, ASampledCommandIsNotOneOfWhichNothingIsSaid) {
  const auto throttle = [](const char* hold) {
    return map_of(std::string(R"(, "vx": "v", "d": {"column": "gas")") + hold + "}")[Source::d]->between;
  };
  using enum BetweenRows::Kind;
  EXPECT_FALSE(throttle("").stated);
  EXPECT_EQ(throttle("").used, linear);
  EXPECT_TRUE(throttle(R"(, "hold": "sampled")").stated);
  EXPECT_EQ(throttle(R"(, "hold": "sampled")").used, linear);
  EXPECT_TRUE(throttle(R"(, "hold": "held")").stated);
  EXPECT_EQ(throttle(R"(, "hold": "held")").used, held);
  EXPECT_TRUE(throttle(R"(, "every": 0.1)").stated);
  EXPECT_EQ(throttle(R"(, "every": 0.1)").used, paced);
  EXPECT_EQ(throttle(R"(, "every": 0.1)").every, 0.1);
  EXPECT_FALSE(throttle(R"(, "every": 0)").stated);
}

TEST(LogMap, ChannelsOfAUnitStateItsFrameTogether) {
  const auto place = [](const char* x, const char* y) {
    return std::string(R"(, "x": {"column": "a", "frame": )") + x + R"(}, "y": {"column": "b", "frame": )" + y + "}";
  };
  const Frame frame = map_of(place(R"({"x": 0.4})", R"({"y": 0.1})")).pose;
  EXPECT_EQ(frame.x, 0.4);
  EXPECT_EQ(frame.y, 0.1);
  EXPECT_FALSE(frame.yaw_given);
  EXPECT_EQ(why(place(R"({"x": 0.4, "y": 0.1})", R"({"x": 0.4})")), "accepted");
  EXPECT_THAT(why(place(R"({"x": 0.4, "y": 0.1})", R"({"x": 0})")),
              AllOf(HasSubstr("/channels/y/frame/x"), HasSubstr("another channel of this unit states 0.4 m")));
  EXPECT_THAT(why(place(R"({"x": 0})", R"({"x": 0.4})")), HasSubstr("/channels/y/frame/x"));
}

TEST(LogMap, WhatHasNoDelayOfItsOwnIsGivenNone) {
  const auto throttle = [](const char* delay) {
    return std::string(R"(, "vx": "v", "d": {"column": "gas", "delay": )") + delay + "}";
  };
  EXPECT_EQ(why(throttle("0")), "accepted");
  EXPECT_THAT(why(throttle("\"0.1 s\"")),
              AllOf(HasSubstr("/channels/d/delay"), HasSubstr("delays of the measurements, below 0")));
  EXPECT_THAT(why(throttle("\"find\"")), HasSubstr("/channels/d/delay"));
  EXPECT_THAT(why(R"(, "vx": "v")", R"({"column": "t", "delay": 0.1})"),
              AllOf(HasSubstr("/time/delay"), HasSubstr("expected delays of channels")));
}

TEST(LogMap, LatitudeAndLongitudeAreLateTogether) {
  const auto place = [](const char* delay) {
    return std::string(R"(, "latitude": {"column": "a", "delay": 0.1}, "longitude": {"column": "b", "delay": )") +
           delay + "}";
  };
  EXPECT_EQ(map_of(place("0.1")).delay(0), 0.1);
  EXPECT_THAT(why(place("0")), HasSubstr("differs from that of latitude"));
}

}  // namespace test_log_map
}  // namespace gripline::measured
