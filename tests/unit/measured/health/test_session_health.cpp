#include "measured/health/session_health.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <random>
#include <set>
#include <string>

#include "support/wandering_session.hpp"

namespace gripline::measured {
namespace test_session_health {

using test::wandering;

TEST(Health, TellsRateGapsHeldChannelsAndJumps) {
  SessionFile file;
  file.row_step = 0.04;
  file.session = wandering([](double, std::size_t k, auto& row, auto&, auto&, auto&) {
    if (k % 4 != 0) row[4] = 7.0;
    if (k == 1000) row[2] += 3.0;
  });
  double held = 0.0;
  for (std::size_t i = 0; i < file.session.rows(); ++i) {
    if (i % 4 == 0) held = 0.01 * std::sin(0.01 * static_cast<double>(i));
    file.session.reading[i * 6 + 4] = held;
  }
  for (std::size_t i = 2000; i < file.session.rows(); ++i) file.session.t[i] += 1.0;
  const auto lines = health_of(file);
  const auto has = [&](const char* check, const char* words) {
    return std::any_of(lines.begin(), lines.end(), [&](const Finding& f) {
      return f.check == check && (f.found + f.done).find(words) != std::string::npos;
    });
  };
  EXPECT_TRUE(has("rate", "25 Hz"));
  EXPECT_TRUE(has("gaps", "longest 1.04 s"));
  EXPECT_TRUE(has("vy", "every 4 rows"));
  EXPECT_TRUE(has("yaw", "jumps"));
  EXPECT_TRUE(has("noise of vx", "lag-one correlation"));
}

/// A car that drives for 100 s, read with white noise, and stands for 120 s, where its channels hardly change.
TEST(Health, TheMedianChangeIsThatOfACarThatMoves) {
  constexpr std::array<double, channels> sigma = {0.01, 0.01, 0.002, 0.03, 0.01, 0.01};
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  SessionFile file;
  file.row_step = 0.04;
  Session& s = file.session;
  s = wandering(
      [&](double, std::size_t, auto& row, auto&, auto&, auto&) {
        for (std::size_t c = 0; c < channels; ++c) row[c] += sigma[c] * normal(random);
      },
      100.0);
  std::array<double, channels> rest{s.at(s.rows() - 1, Channel::x), s.at(s.rows() - 1, Channel::y),
                                    s.at(s.rows() - 1, Channel::yaw)};
  for (int k = 0; k < 3000; ++k) {
    s.t.push_back(s.t.back() + file.row_step);
    for (std::size_t c = 0; c < channels; ++c) s.reading.push_back(rest[c] + 1e-3 * sigma[c] * normal(random));
    s.command.push_back({});
  }
  const auto lines = health_of(file);
  const auto line = [&](const std::string& check, const char* words) {
    const auto at = std::ranges::find_if(
        lines, [&](const Finding& f) { return f.check == check && f.found.find(words) != std::string::npos; });
    return at == lines.end() ? std::string() : at->found;
  };
  for (const std::size_t c : {Channel::x, Channel::y, Channel::yaw}) {
    const std::string name = channel_info[c].name, noise = line("noise of " + name, "lag-one");
    EXPECT_EQ(line(name, "jumps"), "") << "driving is no jump";
    EXPECT_NEAR(std::atof(noise.c_str()), sigma[c], 0.1 * sigma[c]) << noise;
  }
}

TEST(Health, OneConstantCommandOrBothAreTold) {
  SessionFile file;
  file.row_step = 0.04;
  file.session = wandering([](double t, std::size_t, auto&, auto& command, auto&, auto&) {
    command.d = 0.3;
    command.delta = 0.1 * std::sin(t);
  });
  const auto lines = constant_commands(file.session);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].check, "d");
  EXPECT_EQ(lines[0].found, "stays between 0.3 and 0.3");
  const auto health = health_of(file);
  EXPECT_TRUE(std::any_of(health.begin(), health.end(),
                          [](const Finding& f) { return f.check == "d" && f.level == Finding::Level::bad; }));
  for (auto& command : file.session.command) command.delta = 0.05;
  EXPECT_EQ(constant_commands(file.session).size(), 2u);
}

/// A receiver of 12.5 Hz in rows of 25 Hz.
TEST(SessionHealth, EveryOtherRowThatRepeatsIsHeld) {
  const auto hints = [](std::size_t rows) {
    std::array<double, 6> last{};
    SessionFile file;
    file.row_step = 0.04;
    file.session = wandering([&](double, std::size_t k, auto& row, auto&, auto, auto) {
      if (k % rows == 0) last = row;
      row[0] = last[0], row[1] = last[1];
    });
    std::string names;
    for (const Finding& f : health_of(file))
      if (f.done.find("\"hold\": \"held\"") != std::string::npos) names += f.check + " " + f.found + "; ";
    return names;
  };
  EXPECT_EQ(hints(1), "");
  EXPECT_EQ(hints(2), "x a new value every 2 rows; y a new value every 2 rows; ");
}

/// A receiver of 5 Hz in rows of 25 Hz: its steps are no slips of a clock, and not what a simulation or a filter leaves.
TEST(SessionHealth, ReadingsThatRepeatHaveNeitherSlipsNorNoise) {
  std::array<double, 6> last{};
  SessionFile file;
  file.row_step = 0.04;
  file.session = wandering([&](double, std::size_t k, auto& row, auto&, auto, auto) {
    if (k % 5 == 0) last = row;
    row[0] = last[0], row[1] = last[1];
  });
  std::set<std::string> checks;
  for (const Finding& f : health_of(file)) checks.insert(f.check);
  EXPECT_TRUE(checks.contains("x"));
  EXPECT_TRUE(checks.contains("noise of vx"));
  for (const char* said : {"position", "noise of x", "noise of y"}) EXPECT_FALSE(checks.contains(said)) << said;
}

TEST(SessionHealth, CommandsThatRepeatInStepAreToldUnlessTheMapSaysWhatThatMeans) {
  SessionFile file;
  file.row_step = 0.04;
  file.session = wandering([](double, std::size_t, auto&, auto&, auto&, auto&) {});
  const auto told = [&] {
    std::string names;
    for (const Finding& f : health_of(file))
      if (f.done.find("linear between rows: say \"hold\": \"held\"") != std::string::npos)
        names += f.check + " " + f.found + "; ";
    return names;
  };
  EXPECT_EQ(told(), "") << "commands that do not repeat";
  file.session.throttle_between.repeats = 2;
  file.session.steering_between.repeats = 1.6;
  EXPECT_EQ(told(), "d a new value every 2 rows; delta a new value every 1.6 rows; ");
  file.session.throttle_between.stated = true;
  EXPECT_EQ(told(), "delta a new value every 1.6 rows; ");
  file.session.prescribed_speed = true;
  file.session.throttle_between.stated = false;
  EXPECT_EQ(told(), "delta a new value every 1.6 rows; ") << "there is no throttle";
}

}  // namespace test_session_health
}  // namespace gripline::measured
