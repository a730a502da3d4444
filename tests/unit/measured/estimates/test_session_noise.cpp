#include "measured/estimates/session_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <string>

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

/// A channel with coloured noise, from the same draws at whatever times it is read.
class UnevenRows {
 public:
  /// `motion`: of time [s]; `jitter`: share of a step that each is longer or shorter by at most. The noise fades by
  /// `colour` within a typical step, or from each reading to the next.
  template <class Motion>
  static std::optional<Noise> read(double colour, double jitter, Motion motion, bool fades_with_time) {
    UnevenRows rows;
    double t = 0.0, state = rows.normal_(rows.random_);
    for (std::size_t k = 0; k < count; ++k) {
      rows.add(t, motion(t) + sigma * state);
      const double step = 1.0 + jitter * rows.jitter_(rows.steps_);
      t += step * sample_time;
      const double fade = colour > 0.0 ? std::pow(colour, fades_with_time ? step : 1.0) : 0.0;
      state = fade * state + std::sqrt(1.0 - fade * fade) * rows.normal_(rows.random_);
    }
    return noise_of(rows.session_, read_channel, sample_time);
  }
  /// The same read evenly, and stamped wrongly by so much of a step at most.
  template <class Motion>
  static std::optional<Noise> stamped(double colour, double jitter, Motion motion) {
    UnevenRows rows;
    double state = rows.normal_(rows.random_);
    for (std::size_t k = 0; k < count; ++k) {
      const double t = static_cast<double>(k) * sample_time;
      rows.add(t + jitter * sample_time * rows.jitter_(rows.steps_), motion(t) + sigma * state);
      state = colour * state + std::sqrt(1.0 - colour * colour) * rows.normal_(rows.random_);
    }
    return noise_of(rows.session_, read_channel, sample_time);
  }

 private:
  static constexpr std::size_t count = 20'000;
  void add(double t, double reading) {
    session_.t.push_back(t);
    session_.reading.resize(session_.reading.size() + channels, not_a_number);
    session_.reading[session_.reading.size() - channels + read_channel] = reading;
  }
  std::mt19937_64 random_{3}, steps_{103};
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> jitter_{-1.0, 1.0};
  Session session_;
};

double straight(double t) { return 20.0 * t; }
double circling(double t) { return 40.0 * std::sin(0.5 * t); }
double standing(double) { return 0.0; }

/// Fourth differences say little of a strong colour: what is asked there is what even rows show.
TEST(SessionNoise, OfUnevenRowsIsThatOfEvenOnes) {
  for (const double colour : {0.0, 0.3, 0.6, 0.8}) {
    const auto even = UnevenRows::read(colour, 0.0, straight, true);
    ASSERT_TRUE(even);
    EXPECT_NEAR(even->sigma, sigma, (colour > 0.7 ? 0.25 : 0.2) * sigma) << colour;
    for (const double jitter : {0.15, 0.3, 0.5})
      for (const auto motion : {circling, standing})
        for (const bool fades_with_time : {true, false}) {
          const auto noise = UnevenRows::read(colour, jitter, motion, fades_with_time);
          const std::string of = std::to_string(colour) + ", jitter " + std::to_string(jitter);
          ASSERT_TRUE(noise) << of;
          EXPECT_NEAR(noise->colour, even->colour, 0.15) << of;
          EXPECT_NEAR(noise->sigma, even->sigma, 0.2 * even->sigma) << of;
        }
  }
}

TEST(SessionNoise, OfEvenReadingsWithStampsThatJitterIsThatOfEvenOnes) {
  for (const double colour : {0.0, 0.3, 0.6, 0.8}) {
    const auto even = UnevenRows::stamped(colour, 0.0, straight);
    ASSERT_TRUE(even);
    for (const double jitter : {0.15, 0.29, 0.45})
      for (const auto motion : {straight, circling, standing}) {
        const auto noise = UnevenRows::stamped(colour, jitter, motion);
        const double least = jitter < 0.3 ? 1e-3 : 0.1;  // of more, some fives seem to have a gap
        ASSERT_TRUE(noise);
        EXPECT_NEAR(noise->colour, even->colour, least) << colour << ' ' << jitter;
        EXPECT_NEAR(noise->sigma, even->sigma, least * even->sigma) << colour << ' ' << jitter;
      }
  }
}

}  // namespace test_session_noise
}  // namespace gripline::measured
