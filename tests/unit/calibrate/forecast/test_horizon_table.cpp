#include "calibrate/forecast/horizon_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <sstream>

#include "calibrate/forecast/baselines.hpp"

namespace gripline::calibrate {
namespace test_horizon_table {

TEST(HorizonTable, RootMeanSquaresWithIntervalsOverBlocks) {
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  std::vector<double> when, predicted, truth;
  for (int i = 0; i < 600; ++i) {
    when.push_back(0.5 * i);
    for (std::size_t c = 0; c < channels; ++c) {
      truth.push_back(c == 4 ? NAN : c == 2 ? 3.1 : 0.0);
      predicted.push_back(c == 2 ? -3.1 : 0.3 * normal(random));
    }
  }
  const HorizonRow row = horizon_row("model", when, predicted, truth);
  EXPECT_NEAR(row.error[0].rms, 0.3 * std::sqrt(2.0), 0.03);
  EXPECT_NEAR(row.error[1].rms, 2 * std::numbers::pi - 6.2, 1e-9);  // the short way round
  EXPECT_NEAR(row.error[2].rms, 0.3, 0.03);
  EXPECT_EQ(row.error[3].count, 0u);
  EXPECT_LT(row.error[2].low, row.error[2].rms);
  EXPECT_GT(row.error[2].high, row.error[2].rms);
  EXPECT_NEAR(row.error[2].high - row.error[2].low, 4 * 0.3 / std::sqrt(2 * 600.0), 0.02);
  std::ostringstream out;
  print_horizon_table(out, std::vector{row});
  EXPECT_THAT(out.str(), testing::Not(testing::HasSubstr("nan")));
}

TEST(HorizonTable, AnErrorOfAWildReadingFitsItsColumn) {
  HorizonRow row;
  row.name = "this world";
  for (HorizonError& e : row.error) e = {.rms = 2.5e28, .low = 0.1, .high = 4e28, .count = 9};
  std::ostringstream out;
  print_horizon_table(out, std::vector{row});
  EXPECT_THAT(out.str(),
              testing::AllOf(testing::HasSubstr("2.5e+28 (0.1..4e+28)"), testing::Not(testing::HasSubstr("0000000"))));
}

/// A car on a circle to the left, 5 m/s, 0.5 rad/s.
Session circling() {
  Session s;
  s.has.fill(true);
  for (int k = 0; k < 100; ++k) {
    const double t = 0.05 * k, yaw = 0.5 * t;
    s.t.push_back(t);
    for (const double v : {10 * std::sin(yaw), 10 - 10 * std::cos(yaw), yaw, 5.0, 0.0, 0.5}) s.reading.push_back(v);
    s.command.push_back({0.0, std::atan(0.5 * 2.0 / 5.0)});
  }
  return s;
}

TEST(Baselines, GoRoundWithTheCarOrStraightOn) {
  const Session s = circling();
  const Starts starts{{1.0}, {0.5, 1.0}};
  for (const Baseline which : {Baseline::persistence, Baseline::kinematic}) {
    const auto p = baseline(which, s, starts, 2.0);
    for (std::size_t c = 0; c < channels; ++c)
      EXPECT_NEAR(p[channels + c], s.interpolate(c, 2.0), 1e-9) << baseline_names[static_cast<std::size_t>(which)] << c;
  }
  const auto p = baseline(Baseline::constant_speed, s, starts, 2.0);
  EXPECT_NEAR(std::hypot(p[channels] - s.at(20, 0), p[channels + 1] - s.at(20, 1)), 5.0, 1e-9);
  EXPECT_EQ(p[channels + 5], 0.0);
}

}  // namespace test_horizon_table
}  // namespace gripline::calibrate
