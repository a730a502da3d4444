#include "measured/log/log_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/noisy_channel.hpp"

namespace gripline::measured {
namespace test_log_noise {

using namespace test::noisy_channel;

TEST(LogNoise, WhiteNoiseOnAnEvenGridIsFoundAgain) {
  Log log;
  log.dt = sample_time;
  log.reading = noisy(0.0);
  log.command.resize(samples);
  const Channels found = estimate_noise({&log, 1});
  EXPECT_NEAR(found[read_channel], sigma, 0.05 * sigma);
  EXPECT_TRUE(std::isnan(found[0])) << "never read";
}

/// Every second or third sample, two of five, four of five; and a channel that stops and goes on.
TEST(LogNoise, WhiteNoiseIsFoundInReadingsSomeSamplesApart) {
  const auto found = [](auto in) {
    Log log;
    log.dt = sample_time;
    log.reading = noisy(0.0);
    log.command.resize(samples);
    for (std::size_t k = 0; k < samples; ++k)
      if (!in(k)) log.reading[k * channels + read_channel] = not_a_number;
    return estimate_noise({&log, 1})[read_channel];
  };
  EXPECT_NEAR(found([](std::size_t k) { return k % 2 == 0; }), sigma, 0.15 * sigma);
  EXPECT_NEAR(found([](std::size_t k) { return k % 3 == 1; }), sigma, 0.15 * sigma);
  EXPECT_NEAR(found([](std::size_t k) { return k % 5 == 0 || k % 5 == 2; }), sigma, 0.15 * sigma);
  EXPECT_NEAR(found([](std::size_t k) { return k % 5 != 0; }), sigma, 0.15 * sigma);
  EXPECT_NEAR(found([](std::size_t k) { return k / 100 % 2 == 0; }), sigma, 0.15 * sigma);
  EXPECT_TRUE(std::isnan(found([](std::size_t k) { return k % 2000 == 0; }))) << "three readings";
}

}  // namespace test_log_noise
}  // namespace gripline::measured
