#include "measured/estimates/session_noise.hpp"

#include <gtest/gtest.h>

#include <random>

#include "support/noisy_channel.hpp"

namespace gripline::measured {
namespace test_session_noise {

using namespace test::noisy_channel;

TEST(SessionNoise, SizeAndColourAreFoundAgain) {
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
TEST(SessionNoise, OfAChannelOfFewRowsIsThatOfItsReadings) {
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
                        +[](std::size_t k) { return k % 6 != 0; },  // no two differences follow each other
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

/// The noisy channel of a car at 20 m/s that is read at times that jitter, or read evenly and stamped so.
std::optional<Noise> at_uneven_times(double colour, bool read_then) {
  Session s;
  s.reading = noisy(colour);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> jitter(-0.15, 0.15);
  double t = 0.0;
  for (std::size_t k = 0; k < samples; ++k) {
    s.t.push_back(read_then ? t : (static_cast<double>(k) + jitter(random)) * sample_time);
    s.reading[k * channels + read_channel] += 20.0 * (read_then ? t : static_cast<double>(k) * sample_time);
    t += (1.0 + jitter(random)) * sample_time;
  }
  return noise_of(s, read_channel, sample_time);
}

TEST(SessionNoise, MotionBetweenUnevenRowsIsNoNoise) {
  for (const double colour : {0.0, 0.3})
    for (const bool read_then : {true, false}) {
      const auto noise = at_uneven_times(colour, read_then);
      ASSERT_TRUE(noise);
      EXPECT_NEAR(noise->colour, colour, 0.15) << read_then;
      EXPECT_NEAR(noise->sigma, sigma, 0.25 * sigma) << colour << ' ' << read_then;
    }
}

}  // namespace test_session_noise
}  // namespace gripline::measured
