#include "world/sensors.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "support/host_support.hpp"

namespace gripline {
namespace test_sensors {

using testing::HasSubstr;
using namespace testing_support;

constexpr double dt = 0.02;

SensorSpec spec_of(const char* text) {
  Errors errors;
  const SensorSpec spec = read_sensors(json(text), dt, errors);
  errors.throw_if_any();
  return spec;
}

/// A truth that names its step in every channel.
Reading<double> truth(std::int64_t step) {
  const auto k = static_cast<double>(step);
  return {k, 100 + k, 200 + k, 300 + k, 400 + k, 500 + k};
}

TEST(Sensors, PerfectOnesShowTheTruth) {
  const SensorSpec spec = spec_of("{}");
  Sensors sensors(spec, 1);
  for (int k = 0; k < 5; ++k) {
    const Reading<double> seen = sensors.sense(k, truth(k));
    EXPECT_EQ(seen.x, truth(k).x);
    EXPECT_EQ(seen.omega, truth(k).omega);
  }
}

TEST(Sensors, JsonGivesUnitsPerChannel) {
  const SensorSpec spec = spec_of(R"({"sigma": {"x": "2 mm", "yaw": "0.2 deg", "yaw_rate": 0.05},
    "bias": {"vx": "0.36 km/h"}, "rate": {"y": "10 Hz"}, "delay": {"vy": "60 ms"}})");
  EXPECT_DOUBLE_EQ(spec.channels[0].sigma, 0.002);
  EXPECT_NEAR(spec.channels[2].sigma, 0.2 * std::numbers::pi / 180, 1e-15);
  EXPECT_DOUBLE_EQ(spec.channels[5].sigma, 0.05);
  EXPECT_DOUBLE_EQ(spec.channels[3].bias, 0.1);
  EXPECT_EQ(spec.channels[1].every, 5);
  EXPECT_EQ(spec.channels[4].delay, 3);
}

TEST(Sensors, NoiseHasItsMomentsIndependentOverTimeAndChannels) {
  const SensorSpec spec = spec_of(R"({"sigma": {"x": 0.5, "vx": 2}, "bias": {"x": 3}})");
  Sensors sensors(spec, 7);
  const int n = 20000;
  double sum = 0, squares = 0, lag = 0, cross = 0, last = 0, tails = 0;
  for (int k = 0; k < n; ++k) {
    const Reading<double> seen = sensors.sense(k, {});
    const double e = (seen.x - 3) / 0.5;
    sum += e;
    squares += e * e;
    lag += e * last;
    cross += e * seen.vx / 2;
    tails += std::abs(e) > 2 ? 1 : 0;
    last = e;
    EXPECT_EQ(seen.y, 0);
  }
  const double tolerance = 4 / std::sqrt(n);
  EXPECT_NEAR(sum / n, 0, tolerance);
  EXPECT_NEAR(squares / n, 1, 1.5 * tolerance);
  EXPECT_NEAR(lag / n, 0, tolerance);
  EXPECT_NEAR(cross / n, 0, tolerance);
  EXPECT_NEAR(tails / n, 0.0455, 0.006);  // Gaussian beyond two sigma
}

/// Plugins draw from the run's seed as well: none has the noise by accident.
TEST(Sensors, AGeneratorThatStartsFromTheSeedItselfDrawsSomethingElse) {
  const SensorSpec spec = spec_of(R"({"sigma": {"x": 1}})");
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    Sensors sensors(spec, seed);
    std::mt19937_64 random(seed);
    const auto uniform = [&] { return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53; };
    const int pairs = 5000;
    double cross = 0;
    for (int k = 0; k < pairs; ++k) {  // two numbers at a time, as the sensors do
      const double r = std::sqrt(-2.0 * std::log(uniform())), angle = 2.0 * std::numbers::pi * uniform();
      cross += sensors.sense(2 * k, {}).x * r * std::cos(angle);
      cross += sensors.sense(2 * k + 1, {}).x * r * std::sin(angle);
    }
    EXPECT_NEAR(cross / (2 * pairs), 0.0, 4.5 / std::sqrt(2 * pairs)) << "seed " << seed;
  }
}

TEST(Sensors, TheSeedDecidesTheNoise) {
  const SensorSpec spec = spec_of(R"({"sigma": {"x": 1, "yaw_rate": 1}})");
  Sensors one(spec, 5), same(spec, 5), other(spec, 6);
  bool differs = false;
  for (int k = 0; k < 50; ++k) {
    const Reading<double> a = one.sense(k, {}), b = same.sense(k, {}), c = other.sense(k, {});
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.omega, b.omega);
    differs = differs || a.x != c.x;
  }
  EXPECT_TRUE(differs);
}

TEST(Sensors, ARateHoldsTheLastReading) {
  Sensors sensors(spec_of(R"({"rate": {"x": "10 Hz"}})"), 1);
  for (int k = 0; k < 23; ++k) {
    const Reading<double> seen = sensors.sense(k, truth(k));
    EXPECT_EQ(seen.x, k - k % 5);
    EXPECT_EQ(seen.y, 100 + k);
  }
}

TEST(Sensors, TellWhichReadingsAreNew) {
  const SensorSpec spec = spec_of(R"({"rate": {"x": "10 Hz", "vy": "25 Hz"}, "delay": {"y": "40 ms"}})");
  for (int k = 0; k < 23; ++k) {
    ChannelSet expected = ChannelSet().set();
    expected[0] = k % 5 == 0;
    expected[4] = k % 2 == 0;
    EXPECT_EQ(spec.read_at(k), expected) << k;
  }
}

TEST(Sensors, ADelayShowsAnEarlierStateAndFirstTheFirst) {
  Sensors sensors(spec_of(R"({"delay": {"x": "60 ms", "vx": "20 ms"}, "bias": {"vx": 0.5}})"), 1);
  for (int k = 0; k < 20; ++k) {
    const Reading<double> seen = sensors.sense(k, truth(k));
    EXPECT_EQ(seen.x, std::max(0, k - 3));
    EXPECT_EQ(seen.vx, 300 + std::max(0, k - 1) + 0.5);
    EXPECT_EQ(seen.vy, 400 + k);
  }
}

TEST(Sensors, ADelayedSlowSensorIsBoth) {
  Sensors sensors(spec_of(R"({"rate": {"x": "25 Hz"}, "delay": {"x": "60 ms"}})"), 1);
  for (int k = 0; k < 20; ++k) EXPECT_EQ(sensors.sense(k, truth(k)).x, std::max(0, k - k % 2 - 3));
}

TEST(Sensors, OneChannelsRateDoesNotChangeAnothersNoise) {
  Sensors fast(spec_of(R"({"sigma": {"x": 1, "y": 1}})"), 3);
  Sensors slow(spec_of(R"({"sigma": {"x": 1, "y": 1}, "rate": {"x": "10 Hz"}})"), 3);
  for (int k = 0; k < 40; ++k) EXPECT_EQ(fast.sense(k, {}).y, slow.sense(k, {}).y);
}

TEST(Sensors, ADelayMayBeAsLongAsARace) { EXPECT_EQ(spec_of(R"({"delay": {"x": 20000}})").channels[0].delay, 1000000); }

TEST(Sensors, RefusalsSayWhatAndWhere) {
  const auto why = [](const char* text) { return refusal([&] { spec_of(text); }); };
  EXPECT_THAT(
      why(R"({"rate": {"x": "30 Hz"}})"),
      HasSubstr("/rate/x: the time between readings is not a multiple of the control step of 0.02 s; nearest: 0.04 s"));
  EXPECT_THAT(why(R"({"delay": {"x": "50 ms"}})"),
              HasSubstr("/delay/x: the delay is not a multiple of the control step"));
  EXPECT_THAT(why(R"({"delay": {"x": 1e8}})"),
              HasSubstr("/delay/x: the delay is longer than 20000 s, a million control steps of 0.02 s"));
  EXPECT_THAT(why(R"({"delay": {"x": 1e300}})"), HasSubstr("/delay/x: the delay is longer than 20000 s"));
  EXPECT_THAT(why(R"({"rate": {"x": 1e-300}})"), HasSubstr("/rate/x: the time between readings is longer than"));
  EXPECT_THAT(why(R"({"sigma": {"x": -1}})"), HasSubstr("/sigma/x: -1 is out of range"));
  EXPECT_THAT(
      why(R"({"delay": "20 ms"})"),
      HasSubstr("/delay: expected an object by channel (x, y, yaw, vx, vy, yaw_rate), such as {\"x\": \"20 ms\"}; "
                "found \"20 ms\""));
  EXPECT_THAT(why(R"({"sigma": {"omega": 1}})"), HasSubstr("/sigma/omega: unknown key \"omega\""));
  EXPECT_THAT(why(R"({"sigma": {"x": "1 kg"}})"), HasSubstr("is a mass, expected a length [m]"));
  EXPECT_THAT(why(R"({"noise": {"x": 1}})"), HasSubstr("unknown key \"noise\"; known: sigma, bias, rate, delay"));
  EXPECT_THAT(why(R"({"sigma": {"x": 1}, "dealy": {"x": 1}})"), HasSubstr("did you mean \"delay\"?"));
  EXPECT_THAT(why(R"({"rate": {"x": 0}})"), HasSubstr("/rate/x: 0 is out of range"));
}

}  // namespace test_sensors
}  // namespace gripline
