#include "calibrate/forecast/baselines.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace gripline::calibrate {
namespace test_baselines {

/// A car on a circle to the left, 5 m/s, 0.5 rad/s, heading north at first.
Session circling() {
  Session s;
  s.has.fill(true);
  for (int k = 0; k < 400; ++k) {
    const double t = 0.01 * k, turned = 0.5 * t, yaw = 0.5 * std::numbers::pi + turned;
    s.t.push_back(t);
    for (const double v : {10 * std::cos(turned), 10 * std::sin(turned), yaw, 5.0, 0.0, 0.5}) s.reading.push_back(v);
    s.command.push_back({0.0, std::atan(0.5 * 2.0 / 5.0)});
  }
  return s;
}

/// Leaves readings out of the rows from `first` on, every `step`.
void leave_out(Session& s, std::size_t channel, std::size_t first, std::size_t step = 1) {
  for (std::size_t i = first; i < s.rows(); i += step) s.reading[i * channels + channel] = NAN;
}

const Starts starts{{2.0}, {0.5, 1.0}};

void expect_as_driven(const Session& s) {
  const Session whole = circling();
  for (const Baseline which : {Baseline::persistence, Baseline::kinematic}) {
    const auto p = baseline(which, s, starts, 2.0);
    for (std::size_t c = 0; c < channels; ++c)
      EXPECT_NEAR(p[channels + c], whole.interpolate(c, 3.0), 2e-3)
          << baseline_names[static_cast<std::size_t>(which)] << c;
  }
}

TEST(Baselines, TakeYawAndTurnRateFromTheRowBeforeWhereTheyAreReadInOthers) {
  Session s = circling();
  for (const std::size_t c : {2u, 5u}) leave_out(s, c, 0, 2);
  ASSERT_TRUE(std::isnan(s.interpolate(2, 2.0)));
  expect_as_driven(s);
}

TEST(Baselines, MoveAnOlderPlaceOnToTheStart) {
  Session s = circling();
  for (const std::size_t c : {0u, 1u, 3u})
    for (const std::size_t first : {0u, 1u, 2u, 4u}) leave_out(s, c, first, 5);
  ASSERT_TRUE(std::isnan(s.interpolate(0, 2.0)));
  // The place of 20 ms before, along the heading of the start.
  expect_as_driven(s);
}

TEST(Baselines, KnowNoPlaceWithoutAYawAndNoTurnWithoutItsRate) {
  Session s = circling();
  leave_out(s, 2, 100);
  for (const Baseline which : {Baseline::persistence, Baseline::constant_speed, Baseline::kinematic}) {
    const auto p = baseline(which, s, starts, 2.0);
    for (const std::size_t c : {0u, 1u, 2u}) EXPECT_TRUE(std::isnan(p[c])) << c;
    EXPECT_EQ(p[3], 5.0);
  }
  s = circling();
  leave_out(s, 5, 100);
  EXPECT_TRUE(std::isnan(baseline(Baseline::persistence, s, starts, 2.0)[0]));
  EXPECT_FALSE(std::isnan(baseline(Baseline::kinematic, s, starts, 2.0)[0]));
  s.has[5] = false;  // straight on
  EXPECT_NEAR(baseline(Baseline::persistence, s, starts, 2.0)[0], 10 * std::cos(1.0) - 2.5 * std::sin(1.0), 1e-9);
}

/// What its own row shows counts, whatever was read before.
TEST(Baselines, TakeNothingElseWhereTheStartsRowIsFull) {
  Session s = circling();
  for (std::size_t c = 0; c < channels; ++c)
    for (std::size_t i = 0; i < s.rows(); ++i)
      if (i != 200 && i != 201) s.reading[i * channels + c] = NAN;
  const auto p = baseline(Baseline::persistence, s, starts, 2.0);
  const auto whole = baseline(Baseline::persistence, circling(), starts, 2.0);
  ASSERT_FALSE(p.empty());
  ASSERT_EQ(p.size(), whole.size());
  for (std::size_t k = 0; k < p.size(); ++k) EXPECT_EQ(p[k], whole[k]) << k;
}

}  // namespace test_baselines
}  // namespace gripline::calibrate
