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

}  // namespace test_guess_draft
}  // namespace gripline::measured
