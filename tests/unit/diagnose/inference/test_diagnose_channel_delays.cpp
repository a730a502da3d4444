#include "diagnose/inference/channel_delays.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "measured/session/log_map.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_channel_delays {

using test::DiagnoseRig;

/// A log whose channels of one group show what the car did `samples` ago.
LogFile late(const DiagnoseRig& rig, std::uint64_t seed, std::size_t group, std::size_t samples) {
  LogFile file;
  file.stretches.push_back(rig.simulate(rig.catalogue().null_model(), {.seconds = 60, .seed = seed, .unsteady = 1}));
  Log& log = file.stretches.front();
  const Log on_time = log;
  for (std::size_t k = 0; k < log.size(); ++k)
    for (std::size_t c = 0; c < channels; ++c)
      if (measured::delay_group[c] == group || group == measured::delay_groups)
        log.reading[k * channels + c] = on_time.reading[(k - std::min(k, samples)) * channels + c];
  return file;
}

constexpr std::size_t yaw = 1, speeds = 2, yaw_rate = 3, all = measured::delay_groups;

TEST(ChannelDelays, FindsALateYawRate) {
  const DiagnoseRig rig;
  for (const std::size_t samples : {3, 8}) {
    const LogFile log = late(rig, 801, yaw_rate, samples);
    const std::vector<ChannelDelay> found = significant_delays({&log, 1}, SpeedsBy::displacements_too);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found.front().name(), "yaw_rate");
    EXPECT_NEAR(found.front().seconds, 0.02 * static_cast<double>(samples), 0.008);
    EXPECT_LT(found.front().low, found.front().high);
  }
}

TEST(ChannelDelays, FindsLateSpeeds) {
  const DiagnoseRig rig;
  const LogFile log = late(rig, 802, speeds, 6);
  const std::vector<ChannelDelay> found = significant_delays({&log, 1}, SpeedsBy::displacements_too);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found.front().name(), "velocity");
  EXPECT_NEAR(found.front().seconds, 0.12, 0.03);
}

/// No sensor shows what has not happened yet: where the yaw rate seems to be early, the yaw is late.
TEST(ChannelDelays, FindsALateYaw) {
  const DiagnoseRig rig;
  const LogFile log = late(rig, 806, yaw, 6);
  const std::vector<ChannelDelay> found = significant_delays({&log, 1}, SpeedsBy::displacements_too);
  const auto one = std::ranges::find(found, yaw, &ChannelDelay::group);
  ASSERT_NE(one, found.end());
  EXPECT_NEAR(one->seconds, 0.12, 0.03);
  EXPECT_LT(one->low, one->high);
}

/// A delay of all channels is one of the commands as well: no channel is late against another.
TEST(ChannelDelays, NoChannelIsLateWhereAllAreOrNone) {
  const DiagnoseRig rig;
  for (const std::uint64_t seed : {803, 804}) {
    const LogFile none = late(rig, seed, all, 0), every = late(rig, seed, all, 5);
    EXPECT_TRUE(significant_delays({&none, 1}, SpeedsBy::displacements_too).empty());
    EXPECT_TRUE(significant_delays({&every, 1}, SpeedsBy::displacements_too).empty());
  }
}

/// Noise that is correlated from sample to sample moves the best correlation of two channels about. Eight blocks of a
/// log show how far less significantly than many would.
TEST(ChannelDelays, CorrelatedNoiseIsNoDelay) {
  const DiagnoseRig rig;
  measured::Channels colour;
  colour.fill(0.9);
  for (const std::uint64_t seed : {811, 821}) {
    LogFile log;
    log.stretches.push_back(rig.simulate(rig.catalogue().null_model(),
                                         {.seconds = 60, .seed = seed, .noise = 30, .colour = colour, .unsteady = 1}));
    EXPECT_TRUE(significant_delays({&log, 1}, SpeedsBy::displacements_too).empty()) << seed;
  }
}

/// Accelerations drown in the noise of such a place.
TEST(ChannelDelays, OfANoisyPlaceAreNoFalseOnes) {
  const DiagnoseRig rig;
  for (std::uint64_t seed = 830; seed < 842; ++seed) {
    LogFile log = late(rig, seed, all, 0);
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    Log& rows = log.stretches.front();
    for (std::size_t k = 0; k < rows.size(); ++k)
      for (std::size_t c = 0; c < 2; ++c) rows.reading[k * channels + c] += 0.05 * normal(random);
    EXPECT_TRUE(significant_delays({&log, 1}, SpeedsBy::displacements_too).empty()) << seed;
  }
}

/// What is left of a delay moves it; at its limit a fit does not say how sure that is, and without one nothing is.
TEST(ChannelDelays, AreRefinedByWhatAFitLeaves) {
  DiagnoseRig rig;
  const LogFile log = late(rig, 805, all, 0);
  const ChannelDelay place{.group = 0, .seconds = 0.1, .low = 0.09, .high = 0.12},
      rate{.group = yaw_rate, .seconds = 0.1, .low = 0.09, .high = 0.12};
  std::vector both{place, rate};
  keep_open(both, {&log, 1}, rig.catalogue());
  ASSERT_EQ(rig.catalogue().nuisances().size(), 1U);
  const double sigma = rig.catalogue().nuisances().front().sigma;
  EXPECT_NEAR(sigma, 0.015 / 1.96, 1e-4);
  // Of 0.107 s five samples are taken off, and the rest is the model's.
  std::vector between{ChannelDelay{.group = 0, .seconds = 0.107, .low = 0.1, .high = 0.12}};
  keep_open(between, {&log, 1}, rig.catalogue());
  EXPECT_NEAR(between.front().left, 0.007, 1e-12);
  EXPECT_NEAR(rig.catalogue().nuisances().front().nominal, 0.007, 1e-12);
  const LogFile shifted = without_delays(log, between);
  for (std::size_t k = 0; k < 100; ++k)
    EXPECT_EQ(shifted.stretches.front().reading[k * channels], log.stretches.front().reading[(k + 5) * channels]);
  keep_open(both, {&log, 1}, rig.catalogue());
  Fit fit;
  EXPECT_EQ(refined(place, rig.catalogue(), fit).seconds, 0.1);
  fit.theta = {-0.002};
  EXPECT_EQ(refined(place, rig.catalogue(), fit).seconds, 0.1) << "no covariance";
  fit.covariance = {1e-6};
  const ChannelDelay finer = refined(place, rig.catalogue(), fit);
  EXPECT_NEAR(finer.seconds, 0.098, 1e-12);
  EXPECT_NEAR(finer.high - finer.low, 2 * 1.96e-3, 1e-5);
  fit.theta = {2.0 * sigma};
  const ChannelDelay limited = refined(place, rig.catalogue(), fit);
  EXPECT_NEAR(limited.seconds, 0.1 + 2.0 * sigma, 1e-12);
  EXPECT_EQ(limited.low, 0.09);
  EXPECT_GE(limited.high, 0.12);
  EXPECT_EQ(refined(rate, rig.catalogue(), fit).seconds, 0.1);
  std::vector moved = both;
  EXPECT_TRUE(move_limited(moved, rig.catalogue(), fit));
  EXPECT_NEAR(moved[0].seconds, 0.1 + 2.0 * sigma, 1e-12);
  EXPECT_NEAR(moved[0].high - moved[0].low, 0.03, 1e-12);
  EXPECT_EQ(moved[1].seconds, 0.1);
  fit.theta = {-0.002};
  EXPECT_FALSE(move_limited(moved, rig.catalogue(), fit));
  keep_open({}, {&log, 1}, rig.catalogue());
  EXPECT_TRUE(rig.catalogue().nuisances().empty());
}

TEST(ChannelDelays, TakesDelaysOff) {
  const DiagnoseRig rig;
  const LogFile on_time = late(rig, 805, all, 0), log = late(rig, 805, yaw_rate, 4);
  ChannelDelay delay;
  delay.group = yaw_rate;
  delay.seconds = 0.08;
  const LogFile again = without_delays(log, {&delay, 1});
  const auto &was = on_time.stretches.front().reading, &is = again.stretches.front().reading;
  const std::size_t n = on_time.stretches.front().size();
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t c = 0; c < channels; ++c) {
      if (c == 5 && k + 4 >= n)
        EXPECT_TRUE(std::isnan(is[k * channels + c])) << k;
      else
        EXPECT_NEAR(is[k * channels + c], was[k * channels + c], 1e-9) << k << ' ' << c;
    }
  ASSERT_EQ(again.health.size(), 1U);
  EXPECT_EQ(again.health.front().check, "delay of yaw_rate");
}

/// A channel that every other row has keeps its readings, by a whole number of samples or not.
TEST(ChannelDelays, TakesDelaysOffChannelsSlowerThanTheRows) {
  const DiagnoseRig rig;
  LogFile log = late(rig, 805, all, 0);
  Log& rows = log.stretches.front();
  const std::vector<double> every = rows.reading;
  for (std::size_t k = 1; k < rows.size(); k += 2) rows.reading[k * channels + 2] = std::nan("");
  for (const double seconds : {0.08, 0.09}) {
    ChannelDelay delay;
    delay.group = yaw;
    delay.seconds = seconds;
    const std::vector<double> moved = without_delays(log, {&delay, 1}).stretches.front().reading;
    std::size_t read = 0;
    for (std::size_t k = 0; k + 6 < rows.size(); ++k) {
      const double is = moved[k * channels + 2];
      if (std::isnan(is)) continue;
      ++read;
      EXPECT_NEAR(is, every[(k + 4) * channels + 2], 0.12) << k;  // half a sample more, and what was filled in
    }
    EXPECT_NEAR(static_cast<double>(read), 0.5 * static_cast<double>(rows.size()), 8.0) << seconds;
  }
}

}  // namespace test_diagnose_channel_delays
}  // namespace gripline::diagnose
