#include "measured/session/channel_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <ostream>

#include "measured/session/session_file.hpp"
#include "support/session_logs.hpp"

namespace gripline::measured {
namespace test_channel_reader {

using testing::AllOf;
using testing::HasSubstr;
using namespace test;
constexpr double pi = std::numbers::pi;

TEST(ChannelReader, UnitsSignsAndFormulasAreApplied) {
  const auto log = log_of(
      "ms;east;kmh;wheel;gas;off", [](std::ostream& out, double t, double x, double, double, double, double delta) {
        out << 1000 * t << ';' << x << ";36;" << -15 * delta * 180 / pi << ";25;" << (t > 20 ? 1 : 0) << '\n';
      });
  const LogMap map = map_of(R"map({"time": {"column": "ms", "unit": "ms"}, "channels": {
    "vx": {"column": "kmh", "unit": "km/h"}, "yaw_rate": {"formula": "0 * kmh"},
    "delta": {"formula": "wheel / 15", "unit": "deg", "sign": -1},
    "d": {"formula": "if(off > 0.5, 0, gas / 100)"}}})map");
  const Session s = read_session(log, map).session;
  EXPECT_NEAR(s.t[1], 0.05, 1e-12);
  EXPECT_NEAR(s.at(3, 3), 10.0, 1e-12);
  EXPECT_NEAR(s.command[100].delta, 0.6 * std::sin(0.8 * 5.0) * 0.26, 1e-9);
  EXPECT_EQ(s.command[100].d, 0.25);
  EXPECT_EQ(s.command[500].d, 0.0);
  EXPECT_FALSE(s.has[0]);
}

TEST(ChannelReader, AColumnThatIsNotThereIsToldAtTheMapWithTheNearestName) {
  const LogMap map = map_of(channels_json(R"(, "vy": {"column": "stear"})"));
  const std::string message = why(own_log(), map);
  EXPECT_THAT(message, AllOf(HasSubstr("map.json"), HasSubstr("/channels/vy"), HasSubstr("did you mean \"steer\"?")));
  EXPECT_THAT(why(own_log(), gripline_map()), HasSubstr("columns missing"));
}

TEST(ChannelReader, AColumnThatIsReadStandsOnceInTheHeader) {
  const auto twice = [](const char* header) {
    return log_of(header, [](std::ostream& out, double t, double x, double y, double yaw, double rate, double delta) {
      out << t << ',' << x << ',' << y << ',' << yaw << ",10," << rate << ",0.2," << delta << ',' << x << '\n';
    });
  };
  EXPECT_THAT(why(twice("t_s,x_m,y_m,yaw_rad,vx_mps,yaw_rate_radps,d,delta_rad,x_m"), gripline_map()),
              HasSubstr("column x_m stands more than once in the header"));
  EXPECT_EQ(why(twice("t_s,x_m,y_m,yaw_rad,vx_mps,yaw_rate_radps,d,delta_rad,spare"), gripline_map()), "fine");
  const LogMap map = map_of(R"({"time": "t", "channels": {"x": "x", "y": "y", "delta": "delta"}})");
  EXPECT_THAT(why(twice("t,x,y,yaw,v,r,d,delta,x"), map), HasSubstr("column x stands more than once"));
  EXPECT_EQ(why(twice("t,x,y,d,v,r,d,delta,spare"), map), "fine") << "one that is not read";
}

TEST(ChannelReader, TextWhereNumbersBelongIsSaid) {
  const auto some =
      log_with([](std::ostream& out, double t) { out << t << ',' << (t > 9.99 && t < 10.99 ? "10 m/s" : "10"); });
  const SessionFile file = read_session(some, speed_map());
  EXPECT_TRUE(std::isnan(file.session.at(200, Channel::vx)));
  EXPECT_THAT(notes_of(file), HasSubstr("cells: v: 20 are not numbers, the first \"10 m/s\" in line 202; taken"));
  const auto all = log_with([](std::ostream& out, double t) { out << t << ",1.0D+01"; });
  EXPECT_THAT(why(all, speed_map()), AllOf(HasSubstr("column v: none of its cells is a number"),
                                           HasSubstr("\"1.0D+01\""), HasSubstr("log.csv:2:")));
  const auto time = log_with([](std::ostream& out, double t) { out << t << " PM,10"; });
  EXPECT_THAT(why(time, speed_map()), AllOf(HasSubstr("column t: none"), HasSubstr("times are read as 12.5, 1:02.5")));
}

}  // namespace test_channel_reader
}  // namespace gripline::measured
