#include "measured/estimates/session_delays.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "support/wandering_session.hpp"

namespace gripline::measured {
namespace test_session_delays {

using test::wandering;

const PairDelay* find(const std::vector<PairDelay>& all, std::string_view channel, std::string_view against) {
  for (const PairDelay& d : all)
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
  const auto delays = pairwise_delays(s);
  const PairDelay* const rate = find(delays, "yaw_rate", "yaw");
  ASSERT_NE(rate, nullptr);
  EXPECT_NEAR(rate->seconds, 0.31, 0.01);
  EXPECT_LE(rate->low, 0.315);
  EXPECT_GE(rate->high, 0.305);
  EXPECT_LT(rate->high - rate->low, 0.1);
  const PairDelay* const speed = find(delays, "velocity", "position");
  ASSERT_NE(speed, nullptr);
  EXPECT_NEAR(speed->seconds, 0.1, 0.02);
  LogMap map;
  map.channel[5].emplace().delay.reset();
  EXPECT_NEAR(stated_or_found_delays(map, delays)[3], 0.31, 0.01);
  EXPECT_EQ(stated_or_found_delays(map, delays)[2], 0.0);
  map.channel[2].emplace().delay = 0.2;
  EXPECT_NEAR(stated_or_found_delays(map, delays)[3], 0.51, 0.01) << "against a heading that is late itself";
}

TEST(Delays, OfThePlaceIsToldByTheSpeeds) {
  const auto lateness = [](double of_speed) {
    SessionFile file;
    file.session = wandering(
        [&](double t, std::size_t, auto& row, auto&, auto&, auto& speed_at) { row[3] = speed_at(t - of_speed); });
    return place_lateness(file);
  };
  EXPECT_NEAR(lateness(0.1), -0.1, 0.02);
  EXPECT_NEAR(lateness(0.0), 0.0, 0.01);
}

TEST(Delays, AreTheSameAtAnyRate) {
  for (const double hertz : {10.0, 12.0, 16.0, 24.0, 25.0, 33.0, 48.0})
    for (const double late : {0.0, 0.31}) {
      const Session s =
          wandering([&](double t, std::size_t, auto& row, auto&, auto& rate_at, auto&) { row[5] = rate_at(t - late); },
                    200.0, 1.0 / hertz);
      const auto delays = pairwise_delays(s);
      const PairDelay* const rate = find(delays, "yaw_rate", "yaw");
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
    const auto delays = pairwise_delays(wandering(noisy, seconds));
    const PairDelay* const rate = find(delays, "yaw_rate", "yaw");
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
    const auto delays = pairwise_delays(less);
    const PairDelay* const rate = find(delays, "yaw_rate", "yaw");
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
        const auto delays = pairwise_delays(s);
        const PairDelay* const rate = find(delays, "yaw_rate", "yaw");
        ASSERT_NE(rate, nullptr) << of;
        EXPECT_NEAR(rate->seconds, -late, 0.01) << of;
        EXPECT_LT(rate->high - rate->low, 0.04) << of;
        const PairDelay* const speed = find(delays, "velocity", "position");
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
  const auto delays = pairwise_delays(s);
  const PairDelay* const rate = find(delays, "yaw_rate", "yaw");
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
    const auto delays = pairwise_delays_of_file(file);
    return std::pair(find(delays, "yaw_rate", "yaw") != nullptr, find(delays, "velocity", "position") != nullptr);
  };
  EXPECT_EQ(told(), std::pair(true, true));
  for (std::size_t g = 0; g < delay_groups; ++g) EXPECT_TRUE(pose_identifies_delay(file, g)) << delay_names[g];
  file.derived_yaw = true;
  EXPECT_EQ(told(), std::pair(false, true));
  file.derived_velocity = true;
  EXPECT_EQ(told(), std::pair(false, false));
  for (std::size_t g = 0; g < delay_groups; ++g) EXPECT_EQ(pose_identifies_delay(file, g), g < 2) << delay_names[g];
}

TEST(Delays, AreLookedForWhereTheMapLeavesThemOpen) {
  SessionFile file;
  file.session =
      wandering([](double t, std::size_t, auto& row, auto&, auto& rate_at, auto&) { row[5] = rate_at(t - 0.31); });
  LogMap map;
  map.channel[Channel::yaw_rate].emplace().delay = 0.1;
  EXPECT_EQ(delays_to_take_off(map, file).seconds[3], 0.1);
  map.channel[Channel::yaw_rate]->delay.reset();
  const DelaysToTakeOff found = delays_to_take_off(map, file);
  EXPECT_NEAR(found.seconds[3], 0.31, 0.01);
  EXPECT_TRUE(found.remarks.empty());
}

/// What --guess asks for: every delay is to be found.
LogMap open_map() {
  LogMap map;
  for (const std::size_t c : {Channel::x, Channel::y, Channel::yaw, Channel::vx, Channel::yaw_rate})
    map.channel[c].emplace().delay.reset();
  return map;
}

/// Speed and yaw rate so late [s], with noise of the place [m]; rows every `step` [s].
SessionFile late_file(double speed, double rate, double noise, double step) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  SessionFile file;
  file.row_step = step;
  file.session = wandering(
      [&](double t, std::size_t, auto& row, auto&, auto& rate_at, auto& speed_at) {
        row[5] = rate_at(t - rate);
        row[3] = speed_at(t - speed) + 2.0 * noise * normal(random);
        row[0] += noise * normal(random), row[1] += noise * normal(random);
      },
      200.0, step);
  return file;
}

/// However short beside a sample: the interval says that they are there.
TEST(Delays, ThatAreToldFromZeroAreTakenOff) {
  struct {
    double speed, rate, step;
  } const logs[] = {{0.04, 0.04, 0.1}, {0.02, 0.02, 0.05}, {0.008, -0.008, 0.05}, {0.003, 0.003, 0.02}};
  for (const auto& [speed, rate, step] : logs) {
    const DelaysToTakeOff found = delays_to_take_off(open_map(), late_file(speed, rate, 0.0, step));
    EXPECT_NEAR(found.seconds[2], speed, 5e-4) << step;
    EXPECT_NEAR(found.seconds[3], rate, 5e-4) << step;
    EXPECT_THAT(found.remarks, testing::IsEmpty()) << step;
  }
}

/// An estimate within its own uncertainty, or of a small part of a sample, would make a log late that is not.
TEST(Delays, ThatAreNotToldFromZeroAreNotTakenOff) {
  LogMap map = open_map();
  const SessionFile file = late_file(0.006, 0.002, 0.02, 0.05);
  const auto remarks = [](const std::string& velocity, const std::string& yaw_rate) {
    const std::string shorter =
        ") against yaw is shorter than a twentieth of what lies between two readings (0.05 s): ";
    return testing::ElementsAre(
        testing::AllOf(testing::StartsWith("yaw_rate: a delay of 0.002"), testing::EndsWith(shorter + yaw_rate)),
        testing::AllOf(testing::StartsWith("velocity: a delay of 0.00"),
                       testing::EndsWith(") against position is not told from 0: " + velocity)));
  };
  const DelaysToTakeOff found = delays_to_take_off(map, file);
  EXPECT_EQ(found.seconds[2], 0.0);
  EXPECT_EQ(found.seconds[3], 0.0);
  EXPECT_THAT(found.remarks, remarks("none taken off", "none taken off"));
  map.channel[Channel::x]->delay = map.channel[Channel::y]->delay = 0.05;
  map.channel[Channel::yaw]->delay = 0.2;
  const DelaysToTakeOff of_late_pose = delays_to_take_off(map, file);
  EXPECT_EQ(of_late_pose.seconds[2], 0.05);
  EXPECT_EQ(of_late_pose.seconds[3], 0.2);
  EXPECT_THAT(of_late_pose.remarks,
              remarks("taken for as late as the position (0.05 s)", "taken for as late as the yaw (0.2 s)"));
}

TEST(Delays, NothingIsSaidOfWhatDoesNotBelongTogether) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const Session s = wandering([&](double, std::size_t, auto& row, auto& command, auto&, auto&) {
    row[5] = 0.2 * normal(random);
    command.delta = 0.1 * normal(random);
  });
  EXPECT_EQ(find(pairwise_delays(s), "yaw_rate", "yaw"), nullptr);
  EXPECT_EQ(find(pairwise_delays(s), "yaw", "delta"), nullptr);
}

}  // namespace test_session_delays
}  // namespace gripline::measured
