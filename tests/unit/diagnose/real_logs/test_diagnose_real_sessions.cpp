#include "diagnose/real_logs/real_sessions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/errors.hpp"
#include "support/calibrate_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_real_sessions {

using testing::ElementsAre;
using testing::HasSubstr;

measured::SessionFile driven(const std::string& name, unsigned seed) {
  const test::CalibrateRig rig;
  measured::SessionFile file;
  file.session = test::drive(rig.vehicle.car(), {.seconds = 2, .noise = 1, .seed = seed});
  file.session.name = name;
  return file;
}

TEST(RealSessions, ALogThatIsGivenTwiceIsUsedOnce) {
  std::list<measured::SessionFile> files = {driven("a", 1), driven("b", 2), driven("c", 1)}, held_out;
  files.front().session.reading[3] = files.back().session.reading[3] = NAN;  // missing in both
  std::vector<std::string> said;
  use_once(files, held_out, [&](const std::string& line) { said.push_back(line); });
  EXPECT_THAT(said, ElementsAre("c: holds the same rows as a, used once"));
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files.back().session.name, "b");
}

TEST(RealSessions, ALogThatIsFittedIsNoJudgeOfTheFit) {
  std::list<measured::SessionFile> files = {driven("a", 1)}, held_out = {driven("b", 2), driven("c", 1)};
  try {
    use_once(files, held_out, [](const std::string&) {});
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("--held-out c holds the same rows as the log a that is fitted"));
  }
}

/// 120 s of a car whose yaw rate is late [s]; every tenth row: 5 Hz.
measured::SessionFile late(double yaw_rate) {
  const test::CalibrateRig rig;
  const measured::Session all =
      test::drive(rig.vehicle.car(), {.seconds = 120, .noise = 1, .delay = {0, 0, 0, yaw_rate}});
  measured::SessionFile file;
  file.has_throttle = true;
  file.session.name = "late.csv";
  file.session.has = all.has;
  for (std::size_t i = 0; i < all.rows(); i += 10) {
    file.session.t.push_back(all.t[i]);
    file.session.command.push_back(all.command[i]);
    for (std::size_t c = 0; c < measured::channels; ++c) file.session.reading.push_back(all.at(i, c));
  }
  return file;
}

void expect_late(const measured::SessionFile& file, const measured::LogMap& map, double seconds) {
  const std::vector<ChannelDelay> found = significant_delays_beyond_map({file}, map, 2.0);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found.front().name(), "yaw_rate");
  EXPECT_NEAR(found.front().seconds, seconds, 0.05);
}

/// Logs that gripline's own may not be like: slow, steering as a share of lock, without a throttle.
TEST(RealSessions, DelaysAreFoundInWhateverLogsTheMapAllows) {
  measured::SessionFile file = late(0.5);
  for (CommandSample<double>& command : file.session.command) command.delta *= 5.0;
  expect_late(file, measured::gripline_map(), 0.5);
  file.has_throttle = false;
  file.session.prescribed_speed = true;
  expect_late(file, measured::gripline_map(), 0.5);
}

TEST(RealSessions, DelaysThatTheMapStatesAreTakenOffFirst) {
  measured::LogMap map = measured::gripline_map();
  auto& yaw_rate = map.channel[static_cast<std::size_t>(measured::Source::yaw_rate)];
  yaw_rate->delay = 0.2;
  expect_late(late(0.7), map, 0.5);
  yaw_rate->delay = 0.7;
  EXPECT_TRUE(significant_delays_beyond_map({late(0.7)}, map, 2.0).empty());
  yaw_rate->delay.reset();  // to be found
  expect_late(late(0.7), map, 0.7);
}

/// What is found late is fitted, and stands in the world that is returned.
TEST(RealSessions, DelaysThatWereFoundAreLeftToTheFit) {
  const measured::LogMap stated = measured::gripline_map();
  const measured::LogMap map = with_found(stated, significant_delays_beyond_map({late(0.5)}, stated, 2.0));
  EXPECT_EQ(map.delay(3), std::nullopt);
  EXPECT_NEAR(map.delay_start[3].value(), 0.5, 0.05);
  for (const std::size_t group : {0u, 1u, 2u}) EXPECT_EQ(map.delay(group), 0.0) << group;
}

/// A receiver's yaw is late together with its place and speed, of which nothing else tells.
TEST(RealSessions, WhatIsOfOneReceiverWithALateYawIsLeftToTheFitToo) {
  measured::LogMap stated = measured::gripline_map();
  const auto delay = [](std::size_t group, double seconds) {
    return ChannelDelay{.group = group, .seconds = seconds, .low = seconds, .high = seconds};
  };
  const std::vector<ChannelDelay> yaw = {delay(1, 0.15)}, both = {delay(1, 0.15), delay(2, 0.25)};
  measured::LogMap map = with_found(stated, yaw);
  for (const std::size_t group : {0u, 1u, 2u}) {
    EXPECT_EQ(map.delay(group), std::nullopt) << group;
    EXPECT_EQ(map.delay_start[group], 0.15) << group;
  }
  EXPECT_EQ(map.delay(3), 0.0);
  map = with_found(stated, both);
  EXPECT_EQ(map.delay_start[2], 0.25);
  stated.find_delay(1, 0.4);
  EXPECT_EQ(with_found(stated, yaw).delay_start[1], 0.4) << "to be found already";
}

TEST(RealSessions, ALogWithoutAnythingToTellADelayByHasNone) {
  measured::SessionFile slow = late(0.5), bare = late(0.5);
  EXPECT_TRUE(significant_delays_beyond_map({slow}, measured::gripline_map(), 100.0).empty());
  bare.session.has[measured::Channel::yaw] = false;
  for (std::size_t i = 0; i < bare.session.rows(); ++i)
    bare.session.reading[i * measured::channels + measured::Channel::yaw] = NAN;
  EXPECT_TRUE(significant_delays_beyond_map({bare}, measured::gripline_map(), 2.0).empty());
}

/// A log with the place and these channels alone.
measured::SessionFile with_only(const measured::Session& all, std::initializer_list<std::size_t> read) {
  DelimitedTable table;
  table.name = {"t_s", "delta_rad"};
  table.column = {all.t, {}};
  for (const auto& command : all.command) table.column[1].push_back(command.delta);
  for (const std::size_t c : read) {
    table.name.emplace_back(measured::channel_info[c].column);
    table.column.emplace_back();
    for (std::size_t i = 0; i < all.rows(); ++i) table.column.back().push_back(all.at(i, c));
  }
  table.unit.resize(table.name.size());
  for (std::size_t i = 0; i < all.rows(); ++i) table.line.push_back(static_cast<int>(i) + 2);
  return measured::read_session(std::move(table), measured::gripline_map());
}

/// A slow car's course leads its heading.
TEST(RealSessions, NoYawRateIsLateAgainstACourse) {
  using measured::Channel;
  const test::CalibrateRig rig;
  const measured::SessionFile file = with_only(test::drive(rig.vehicle.car(), {.seconds = 60}),
                                               {Channel::x, Channel::y, Channel::vx, Channel::yaw_rate});
  ASSERT_TRUE(file.derived_yaw);
  EXPECT_TRUE(significant_delays_beyond_map({file}, measured::gripline_map(), 2.0).empty());
}

/// Differences of the place are half a step late by themselves.
TEST(RealSessions, NoSpeedIsLateAgainstThePlaceThatItIsMadeOf) {
  using measured::Channel;
  const test::CalibrateRig rig;
  measured::Session all = test::drive(rig.vehicle.car(), {.seconds = 120});
  measured::Session few;
  for (std::size_t i = 0; i < all.rows(); i += 10) {
    few.t.push_back(all.t[i]);
    few.command.push_back(all.command[i]);
    for (std::size_t c = 0; c < measured::channels; ++c) few.reading.push_back(all.at(i, c));
  }
  const measured::SessionFile file = with_only(few, {Channel::x, Channel::y, Channel::yaw});
  ASSERT_TRUE(file.derived_velocity);
  for (const ChannelDelay& delay : significant_delays_beyond_map({file}, measured::gripline_map(), 2.0))
    ADD_FAILURE() << delay.name() << " " << delay.seconds;
}

}  // namespace test_diagnose_real_sessions
}  // namespace gripline::diagnose
