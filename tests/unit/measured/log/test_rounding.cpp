#include "measured/log/rounding.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "util/numbers.hpp"

namespace gripline::measured {
namespace test_rounding {

double rounded(double v, double step) { return step * std::round(v / step); }

/// A steering angle that walks at random by `move` a sample, over a slow swing.
std::vector<double> walk(std::size_t n, double move) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  std::vector<double> values;
  double shaking = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    shaking = 0.97 * shaking + move * normal(random);
    values.push_back(0.05 * std::sin(0.01 * static_cast<double>(k)) + shaking);
  }
  return values;
}

TEST(Rounding, TheStepIsFound) {
  const std::vector<double> angle = walk(2000, 0.003);
  for (const double step : {0.005, 0.0049087, 0.001}) {
    std::vector<double> values;
    for (const double v : angle) values.push_back(rounded(rounded(v, step), 1e-5) + 0.02);  // written with five digits
    values[100] = not_a_number;
    EXPECT_NEAR(step_of(values), step, 1e-3 * step);
  }
}

TEST(Rounding, ASignalThatIsNotRoundedAndASwitchHaveNone) {
  EXPECT_EQ(step_of(walk(2000, 0.003)), 0.0);
  std::vector<double> pedal;
  for (int k = 0; k < 100; ++k) pedal.push_back(k % 7 < 3 ? 0.0 : k % 7 < 5 ? 0.5 : 1.0);
  EXPECT_EQ(step_of(pedal), 0.0);
  EXPECT_EQ(step_of({}), 0.0);
}

/// Rounded and then unwrapped, yaw is off its multiples by whole turns.
TEST(Rounding, AYawThatWasWrappedHasAStep) {
  Log log;
  log.command.resize(2000);
  for (std::size_t k = 0; k < log.size(); ++k) {
    const double yaw = 0.013 * static_cast<double>(k), wrapped = std::remainder(yaw, 2.0 * std::numbers::pi);
    const double turns = yaw - wrapped;
    for (std::size_t c = 0; c < channels; ++c) log.reading.push_back(c == 2 ? rounded(wrapped, 0.005) + turns : 0.0);
  }
  const Channels steps = reading_steps(std::vector{log});
  EXPECT_NEAR(steps[2], 0.005, 1e-6);
  EXPECT_EQ(steps[0], 0.0);
}

/// How far commands are off, in steps, and what is said of it.
struct Off {
  double written = 0, expected = 0, claimed = 0, lasting = 0, claimed_lasting = 0;
};
Off off_of(const std::vector<double>& angle, double step) {
  Log log;
  for (const double v : angle) log.command.push_back({0.3, rounded(v, step)});
  unround_commands(log, {0.0, step});
  Off out;
  const auto n = static_cast<double>(angle.size());
  const auto error = [&](std::size_t k) { return (angle[k] - log.command[k].delta) / step; };
  double products = 0.0, claimed_products = 0.0;
  for (std::size_t k = 0; k < angle.size(); ++k) {
    const double written = rounded(angle[k], step);
    EXPECT_LE(std::abs(log.command[k].delta - written), 0.5 * step);
    EXPECT_EQ(log.command[k].d, 0.3);
    EXPECT_EQ(log.rounding_error[k].variance[0], 0.0);
    out.written += std::pow((angle[k] - written) / step, 2) / n;
    out.expected += error(k) * error(k) / n;
    out.claimed += log.rounding_error[k].variance[1] / (step * step) / n;
    if (k + 1 == angle.size()) continue;
    products += error(k) * error(k + 1) / n;
    claimed_products += log.rounding_error[k].autoregression[1] * log.rounding_error[k].variance[1] / (step * step) / n;
  }
  out.lasting = products / out.expected;
  out.claimed_lasting = claimed_products / out.claimed;
  return out;
}

TEST(Rounding, ACommandThatRestsIsKnownBetterThanItWasWritten) {
  const Off off = off_of(walk(4000, 0.0005), 0.005);
  EXPECT_NEAR(off.written, 1.0 / 12.0, 0.01);
  EXPECT_LT(off.expected, 0.6 * off.written);
  EXPECT_GT(off.claimed, 0.8 * off.expected);
  EXPECT_LT(off.claimed, 1.7 * off.expected);
  EXPECT_GT(off.lasting, 0.4);
  EXPECT_NEAR(off.claimed_lasting, off.lasting, 0.2);
}

TEST(Rounding, ACommandThatMovesBySeveralStepsHasWhiteErrors) {
  const Off off = off_of(walk(4000, 0.02), 0.005);
  EXPECT_NEAR(off.claimed, 1.0 / 12.0, 0.003);
  EXPECT_NEAR(off.expected, 1.0 / 12.0, 0.006);
  EXPECT_LT(off.claimed_lasting, 0.05);
}

}  // namespace test_rounding
}  // namespace gripline::measured
