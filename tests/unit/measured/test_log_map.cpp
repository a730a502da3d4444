#include "measured/log_map.hpp"

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

}  // namespace test_log_map
}  // namespace gripline::measured
