#include "measured/session_health.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace gripline::measured {
namespace test_session_health {

/// A car on a wandering path; `change` edits each row before it is written.
template <class Change>
Session wandering(Change change, double seconds = 200.0, double dt = 0.04) {
  Session s;
  s.has.fill(true);
  double x = 0, y = 0, yaw = 0;
  const auto n = static_cast<std::size_t>(seconds / dt);
  const auto rate_at = [](double t) { return 0.2 * std::sin(0.7 * t) + 0.1 * std::sin(2.3 * t + std::sin(0.1 * t)); };
  const auto speed_at = [](double t) { return 15.0 + 3.0 * std::sin(0.4 * t) + std::sin(1.9 * t); };
  for (std::size_t k = 0; k < n; ++k) {
    const double t = static_cast<double>(k) * dt;
    std::array<double, 6> row{x, y, yaw, speed_at(t), 0.0, rate_at(t)};
    CommandSample<double> command{0.3, 2.6 * rate_at(t) / speed_at(t)};
    change(t, k, row, command, rate_at, speed_at);
    s.t.push_back(t);
    s.reading.insert(s.reading.end(), row.begin(), row.end());
    s.command.push_back(command);
    const double middle = t + 0.5 * dt, heading = yaw + 0.5 * dt * rate_at(middle);
    x += dt * speed_at(middle) * std::cos(heading);
    y += dt * speed_at(middle) * std::sin(heading);
    yaw += dt * rate_at(middle);
  }
  return s;
}

const auto as_it_is = [](double, std::size_t, auto&, auto&, auto&, auto&) {};

const Delay* find(const std::vector<Delay>& all, std::string_view channel, std::string_view against) {
  for (const Delay& d : all)
    if (channel == d.channel && against == d.against) return &d;
  return nullptr;
}

TEST(Delays, OfAChannelIsFoundWithAnIntervalThatHoldsIt) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const Session s = wandering([&](double t, std::size_t, auto& row, auto&, auto& rate_at, auto& speed_at) {
    row[5] = rate_at(t - 0.31) + 0.01 * normal(random);
    row[3] = speed_at(t - 0.1) + 0.02 * normal(random);
    row[2] += 0.0005 * normal(random);
  });
  const auto delays = delays_of(s);
  const Delay* const rate = find(delays, "yaw_rate", "yaw");
  ASSERT_NE(rate, nullptr);
  EXPECT_NEAR(rate->seconds, 0.31, 0.01);
  EXPECT_LE(rate->low, 0.315);
  EXPECT_GE(rate->high, 0.305);
  EXPECT_LT(rate->high - rate->low, 0.1);
  const Delay* const speed = find(delays, "velocity", "position");
  ASSERT_NE(speed, nullptr);
  EXPECT_NEAR(speed->seconds, 0.1, 0.02);
  LogMap map;
  map.channel[5].emplace().delay.reset();
  EXPECT_NEAR(clock_delays(map, delays)[3], 0.31, 0.01);
  EXPECT_EQ(clock_delays(map, delays)[2], 0.0);
  map.channel[2].emplace().delay = 0.2;
  EXPECT_NEAR(clock_delays(map, delays)[3], 0.51, 0.01) << "against a heading that is late itself";
}

TEST(Delays, AreTheSameAtAnyRate) {
  for (const double hertz : {10.0, 12.0, 16.0, 24.0, 25.0, 33.0, 48.0})
    for (const double late : {0.0, 0.31}) {
      const Session s =
          wandering([&](double t, std::size_t, auto& row, auto&, auto& rate_at, auto&) { row[5] = rate_at(t - late); },
                    200.0, 1.0 / hertz);
      const auto delays = delays_of(s);
      const Delay* const rate = find(delays, "yaw_rate", "yaw");
      ASSERT_NE(rate, nullptr) << hertz;
      EXPECT_NEAR(rate->seconds, late, 0.003) << hertz << " Hz";
    }
}

TEST(Delays, AShortLogSaysHowLittleItKnows) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const auto noisy = [&](double t, std::size_t, auto& row, auto&, auto& rate_at, auto&) {
    row[5] = rate_at(t - 0.31) + 0.05 * normal(random);
  };
  const auto width = [&](double seconds) {
    const auto delays = delays_of(wandering(noisy, seconds));
    const Delay* const rate = find(delays, "yaw_rate", "yaw");
    return rate == nullptr ? NAN : rate->high - rate->low;
  };
  const double of_short = width(15.0), of_long = width(200.0);
  EXPECT_GT(of_short, 1.5 * of_long);
}

/// A channel that is read in a part of the log has as many blocks as that part.
TEST(Delays, BlocksWithoutReadingsDoNotCount) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const Session s = wandering([&](double t, std::size_t, auto& row, auto&, auto& rate_at, auto&) {
    row[5] = rate_at(t - 0.31) + 0.05 * normal(random);
  });
  const auto read_for = [&](double seconds) {
    Session less = s;
    for (std::size_t i = 0; i < s.rows(); ++i)
      if (s.t[i] > seconds) less.reading[i * channels + Channel::yaw_rate] = NAN;
    const auto delays = delays_of(less);
    const Delay* const rate = find(delays, "yaw_rate", "yaw");
    return rate == nullptr ? 0 : rate->blocks;
  };
  EXPECT_EQ(read_for(200.0), 19u);
  EXPECT_EQ(read_for(48.0), 5u);
  EXPECT_EQ(read_for(18.0), 0u);
}

/// Place, heading and speed of a receiver in every so many rows of 50 Hz, late by so much, beside a gyro.
TEST(Delays, ChannelsOfFewRowsAreAsLateAsTheyAre) {
  for (const std::size_t every : {2, 3, 5, 10})
    for (const double late : {0.0, 0.15})
      for (const double noise : {0.0, 1.0, 2.0}) {
        std::mt19937_64 random(5 + every);
        std::normal_distribution<double> normal(0.0, noise);
        const Session s = wandering(
            [&](double t, std::size_t k, auto& row, auto&, auto& rate_at, auto& speed_at) {
              row[5] = rate_at(t + late) + 0.004 * normal(random);
              row[3] = speed_at(t - late) + 0.05 * normal(random);
              row[0] += 0.01 * normal(random), row[1] += 0.01 * normal(random), row[2] += 0.004 * normal(random);
              if (k % every != 1) row[0] = row[1] = row[2] = row[3] = row[4] = NAN;
            },
            200.0, 0.02);
        const std::string of = std::to_string(every) + " rows, noise " + std::to_string(noise);
        const auto delays = delays_of(s);
        const Delay* const rate = find(delays, "yaw_rate", "yaw");
        ASSERT_NE(rate, nullptr) << of;
        EXPECT_NEAR(rate->seconds, -late, 0.01) << of;
        EXPECT_LT(rate->high - rate->low, 0.04) << of;
        const Delay* const speed = find(delays, "velocity", "position");
        if (every < 5 && noise > 0.0) continue;  // differences of the place are noise
        ASSERT_NE(speed, nullptr) << of;
        EXPECT_NEAR(speed->seconds, late, 0.01) << of;
        EXPECT_TRUE(late > 0.0 ? speed->low > 0.05 : speed->low < 0.005 && speed->high > -0.005) << of;
      }
}

/// Sparse readings that stop and go on: nothing is made of what lies in between.
TEST(Delays, GapsOfChannelsOfFewRowsAreNotBridged) {
  const Session s = wandering(
      [&](double t, std::size_t k, auto& row, auto&, auto&, auto&) {
        if (k % 5 != 0 || std::fmod(t, 20.0) > 10.0) row[2] = NAN;
      },
      200.0, 0.02);
  const auto delays = delays_of(s);
  const Delay* const rate = find(delays, "yaw_rate", "yaw");
  ASSERT_NE(rate, nullptr);
  EXPECT_NEAR(rate->seconds, 0.0, 0.003);
}

/// Speeds from differences of the place, and the course, are compared with neither place nor yaw rate.
TEST(Delays, OfWhatWasDerivedNoneIsTold) {
  SessionFile file;
  file.session = wandering([](double t, std::size_t, auto& row, auto&, auto& rate_at, auto& speed_at) {
    row[5] = rate_at(t - 0.31), row[3] = speed_at(t - 0.1);
  });
  const auto told = [&] {
    const auto delays = delays_of(file);
    return std::pair(find(delays, "yaw_rate", "yaw") != nullptr, find(delays, "velocity", "position") != nullptr);
  };
  EXPECT_EQ(told(), std::pair(true, true));
  for (std::size_t g = 0; g < delay_groups; ++g) EXPECT_TRUE(pose_tells_delay(file, g)) << delay_names[g];
  file.derived_yaw = true;
  EXPECT_EQ(told(), std::pair(false, true));
  file.derived_velocity = true;
  EXPECT_EQ(told(), std::pair(false, false));
  for (std::size_t g = 0; g < delay_groups; ++g) EXPECT_EQ(pose_tells_delay(file, g), g < 2) << delay_names[g];
}

TEST(Delays, NothingIsSaidOfWhatDoesNotBelongTogether) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const Session s = wandering([&](double, std::size_t, auto& row, auto& command, auto&, auto&) {
    row[5] = 0.2 * normal(random);
    command.delta = 0.1 * normal(random);
  });
  EXPECT_EQ(find(delays_of(s), "yaw_rate", "yaw"), nullptr);
  EXPECT_EQ(find(delays_of(s), "yaw", "delta"), nullptr);
}

TEST(Slip, APositionThatFallsBackOnceASecondIsSeen) {
  const auto late = [](double t) { return 0.008 * (t - std::floor(t)); };  // falls back 8 ms at every full second
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const Session s = wandering([&](double t, std::size_t, auto& row, auto&, auto&, auto& speed_at) {
    const double ahead = late(t + 1e-9) * speed_at(t);
    row[0] += ahead * std::cos(row[2]) + 0.004 * normal(random);
    row[1] += ahead * std::sin(row[2]) + 0.004 * normal(random);
  });
  const auto slip = slip_of(s, 0.04);
  ASSERT_TRUE(slip);
  EXPECT_EQ(slip->period, 1.0);
  EXPECT_NEAR(slip->travel, -0.008, 0.002);
  EXPECT_FALSE(slip_of(wandering(as_it_is), 0.04));
}

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
