#include "measured/noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "util/numbers.hpp"

namespace gripline::measured {
namespace test_noise {

constexpr double sample_time = 0.04, sigma = 0.05;
constexpr std::size_t read_channel = 3, samples = 5000;

/// A smooth motion.
double motion(std::size_t k) {
  const double t = static_cast<double>(k) * sample_time;
  return 15.0 + 3.0 * std::sin(0.4 * t) + std::sin(1.9 * t);
}

/// Readings of one channel, with noise of a standard deviation `sigma` and a lag-one correlation `colour`.
std::vector<double> noisy(double colour) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  std::vector<double> reading(samples * channels, not_a_number);
  double state = normal(random);
  for (std::size_t k = 0; k < samples; ++k) {
    reading[k * channels + read_channel] = motion(k) + sigma * state;
    state = colour * state + std::sqrt(1 - colour * colour) * normal(random);
  }
  return reading;
}

TEST(Noise, WhiteNoiseOnAnEvenGridIsFoundAgain) {
  Log log;
  log.dt = sample_time;
  log.reading = noisy(0.0);
  log.command.resize(samples);
  const Channels found = estimate_noise({&log, 1});
  EXPECT_NEAR(found[read_channel], sigma, 0.05 * sigma);
  EXPECT_TRUE(std::isnan(found[0])) << "never read";
}

/// Every second or third sample, two of five, four of five; and a channel that stops and goes on.
TEST(Noise, WhiteNoiseIsFoundInReadingsSomeSamplesApart) {
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

TEST(Noise, SizeAndColourAreFoundAgain) {
  for (const double colour : {0.0, 0.3, 0.6}) {
    Session s;
    s.reading = noisy(colour);
    for (std::size_t k = 0; k < samples; ++k) s.t.push_back(static_cast<double>(k) * sample_time);
    const auto noise = noise_of(s, read_channel, sample_time);
    ASSERT_TRUE(noise);
    EXPECT_NEAR(noise->colour, colour, 0.1);
    EXPECT_NEAR(noise->sigma, sigma, 0.2 * sigma) << colour;
    EXPECT_FALSE(noise_of(s, 0, sample_time)) << "never read";
  }
}

/// A receiver in every so many rows, and one whose readings fall into every third and every second row by turns.
TEST(Noise, OfAChannelOfFewRowsIsThatOfItsReadings) {
  const auto found = [](auto in) {
    Session s;
    s.reading = noisy(0.0);
    for (std::size_t k = 0; k < samples; ++k) {
      s.t.push_back(static_cast<double>(k) * sample_time);
      // Uneven readings of what moves evenly show no noise of it.
      s.reading[k * channels + read_channel] += 20.0 * s.t.back();
      if (!in(k)) s.reading[k * channels + read_channel] = not_a_number;
    }
    return noise_of(s, read_channel, sample_time);
  };
  for (const auto in : {+[](std::size_t k) { return k % 2 == 1; }, +[](std::size_t k) { return k % 5 == 2; },
                        +[](std::size_t k) { return k % 5 == 0 || k % 5 == 2; },
                        +[](std::size_t k) { return k % 3 == 0 && k % 100 < 90; }}) {
    const auto noise = found(in);
    ASSERT_TRUE(noise);
    EXPECT_NEAR(noise->sigma, sigma, 0.3 * sigma);
    EXPECT_NEAR(noise->colour, 0.0, 0.35) << "of 1000 readings and more";
  }
  EXPECT_FALSE(found([](std::size_t k) { return k % 25 == 0; })) << "what moves within a second is no noise";
  EXPECT_FALSE(found([](std::size_t k) { return k % 25 == 0 || k % 60 == 7; })) << "nor within uneven ones";
  EXPECT_FALSE(found([](std::size_t k) { return k % 200 == 0; })) << "too few";
}

}  // namespace test_noise
}  // namespace gripline::measured
