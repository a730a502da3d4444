#include "measured/session/session_commands.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "measured/session/session_file.hpp"
#include "support/session_logs.hpp"

namespace gripline::measured {
namespace test_session_commands {

using namespace test;

TEST(SessionCommands, ACommandThatChangesMoreOftenThanTheMapSaysIsSaid) {
  const auto log = log_of("t_s,vx_mps,yaw_rate_radps,delta_rad",
                          [](std::ostream& out, double t, double, double, double, double rate, double) {
                            out << t << ",10," << rate << ',' << 0.01 * std::sin(std::floor(t / 0.1 + 1e-6)) << '\n';
                          });
  const auto said = [&](const char* every) {
    std::string text = R"({"time": "t_s", "channels": {"vx": "vx_mps", "yaw_rate": "yaw_rate_radps",
      "delta": {"column": "delta_rad", "kind": "command", "every": ")";
    text.append(every).append("\"}}}");
    for (const Finding& f : read_session(log, map_of(text)).findings)
      if (f.check == "steering") return std::string(f.found).append("; ").append(f.done);
    return std::string();
  };
  EXPECT_EQ(said("0.1 s"), "");
  EXPECT_EQ(
      said("0.2 s"),
      "changes every 0.1 s, the map says read every 0.2 s; 397 of 399 changes are taken as they stand in the rows");
}

TEST(SessionCommands, ChangesThatComeTooSoonForAWhileAreCountedAsTheyAreRead) {
  // Every 0.1 s for the first four seconds, every 0.2 s after: read one by one, changes up to about 12 s stand.
  const auto log = log_of("t_s,vx_mps,yaw_rate_radps,delta_rad",
                          [](std::ostream& out, double t, double, double, double, double rate, double) {
                            const double pace = t < 4.0 - 1e-6 ? 0.1 : 0.2;
                            out << t << ",10," << rate << ',' << 0.01 * std::sin(std::floor(t / pace + 1e-6)) << '\n';
                          });
  const LogMap map = map_of(R"({"time": "t_s", "channels": {"vx": "vx_mps", "yaw_rate": "yaw_rate_radps",
    "delta": {"column": "delta_rad", "kind": "command", "every": "0.2 s"}}})");
  const SessionFile file = read_session(log, map);
  std::string done;
  for (const Finding& f : file.findings)
    if (f.check == "steering") done = f.done;
  const CommandGrid grid(file.session, 0.01);
  std::size_t stand = 0, changes = 0;
  for (std::size_t i = 1; i < file.session.rows(); ++i) {
    if (file.session.command[i].delta == file.session.command[i - 1].delta) continue;
    ++changes;
    const auto k = static_cast<std::size_t>(std::lround((file.session.t[i] - grid.t0) / grid.dt));
    stand += grid.fixed_at[1][k - 8] < file.session.t[i] - 1e-9;  // no straight line leads there
  }
  EXPECT_GT(stand, 40u);
  EXPECT_LT(stand, changes / 2);
  EXPECT_EQ(done, std::to_string(stand).append(" of ").append(std::to_string(changes)) +
                      " changes are taken as they stand in the rows");
}

/// Commands of 10 Hz in rows of 20 Hz, through maps that say so or do not.
TEST(SessionCommands, WhatCommandsDoBetweenRowsIsStatedUsedAndShown) {
  double last = 0;
  std::size_t k = 0;
  const auto log = log_of("t_s,vx_mps,yaw_rate_radps,d,delta_rad",
                          [&](std::ostream& out, double t, double, double, double, double rate, double delta) {
                            if (k++ % 2 == 0) last = delta;
                            out << t << ",10," << rate << ',' << 0.2 + 0.01 * std::sin(t) << ',' << last << '\n';
                          });
  const auto session = [&](const std::string& more) {
    return read_session(log, map_of(R"({"time": "t_s", "channels": {"vx": "vx_mps", "yaw_rate": "yaw_rate_radps",
      "d": "d", "delta": {"column": "delta_rad")" +
                                    more + "}}}"))
        .session;
  };
  using Kind = BetweenRows::Kind;
  const Session silent = session("");
  EXPECT_EQ(silent.throttle_between.repeats, 1.0);
  EXPECT_NEAR(silent.steering_between.repeats, 2.0, 0.1);
  EXPECT_EQ(silent.steering_between.used, Kind::linear);
  EXPECT_FALSE(silent.throttle_between.is_unexplained());
  EXPECT_TRUE(silent.steering_between.is_unexplained());
  const BetweenRows held = session(R"(, "hold": "held")").steering_between;
  EXPECT_TRUE(held.held());
  EXPECT_FALSE(held.is_unexplained());
  EXPECT_NEAR(held.repeats, 2.0, 0.1) << "whatever is stated";
  const BetweenRows paced = session(R"(, "every": 0.1)").steering_between;
  EXPECT_EQ(paced.used, Kind::paced);
  EXPECT_EQ(paced.every, 0.1);
  EXPECT_FALSE(paced.is_unexplained());
  EXPECT_FALSE(session(R"(, "hold": "sampled")").steering_between.is_unexplained());
  const Session own = read_session(log, gripline_map()).session;
  EXPECT_NEAR(own.steering_between.repeats, 2.0, 0.1);
  EXPECT_FALSE(own.steering_between.is_unexplained()) << "gripline's own logs need no word";
}

}  // namespace test_session_commands
}  // namespace gripline::measured
