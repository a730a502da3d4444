#include "calibrate/fit/fit_starts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "support/circling_session.hpp"

namespace gripline::calibrate {
namespace test_fit_starts {

using measured::Channel;

constexpr double yaw_rate = 0.4;  // [rad/s] of the circling car

TEST(HeldOutTimes, AreTheLastPartOfEveryStretch) {
  const HeldOutTimes times{60, 15};
  for (const double held : {45.1, 59.9, 105.1, 119.9}) EXPECT_TRUE(times.holds(held)) << held;
  for (const double fitted : {0.0, 44.9, 60.1, 104.9}) EXPECT_FALSE(times.holds(fitted)) << fitted;
}

/// A minute with starts every 0.7 s, half a second ahead: that of 44.8 s reaches into what is held out, and is in
/// neither part.
TEST(PartOf, NoHorizonReachesOverTheBoundary) {
  const Session session = test::circling_session(0.02);
  const FitLog all(session, 0.01, {0.2, 0.5}, 0.7, 0.0);
  ASSERT_EQ(all.starts.time.size(), 85u);
  const HeldOutTimes times{60, 15};
  const FitLog fitted = part_of(all, times, false), judged = part_of(all, times, true);
  ASSERT_EQ(fitted.starts.time.size(), 64u);
  ASSERT_EQ(judged.starts.time.size(), 20u);
  EXPECT_NEAR(fitted.starts.time.back(), 44.1, 1e-9);
  EXPECT_NEAR(judged.starts.time.front(), 45.5, 1e-9);
  EXPECT_NEAR(judged.starts.time.back(), 58.8, 1e-9);
  EXPECT_EQ(judged.starts.horizons, all.starts.horizons);
}

TEST(PartOf, StartsKeepTheirTruth) {
  const Session session = test::circling_session(0.02);
  const FitLog all(session, 0.01, {0.2, 0.5}, 0.7, 0.0);
  const FitLog judged = part_of(all, {60, 15}, true);
  ASSERT_EQ(judged.truth.size(), judged.starts.time.size() * 2 * channels);
  for (const std::size_t start : {0u, 7u, 19u})
    for (const std::size_t horizon : {0u, 1u}) {
      const double time = judged.starts.time[start] + judged.starts.horizons[horizon];
      EXPECT_NEAR(judged.truth[judged.starts.reading_index(start, horizon) + Channel::yaw], yaw_rate * time, 1e-9);
    }
}

TEST(Thinned, OneStretchOfFiveSecondsInEverySoMany) {
  const Session session = test::circling_session(0.02);
  const std::vector<FitLog> logs{{session, 0.01, {0.5}, 0.66, 0.0}};
  const auto stretches_of = [](const FitLog& log) {
    std::vector<int> stretches;
    for (const double time : log.starts.time) stretches.push_back(static_cast<int>(time / 5.0));
    stretches.erase(std::unique(stretches.begin(), stretches.end()), stretches.end());
    return stretches;
  };
  EXPECT_EQ(stretches_of(thinned(logs, 2).front()), (std::vector<int>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(stretches_of(thinned(logs, 3).front()), (std::vector<int>{0, 3, 6, 9}));
  EXPECT_EQ(thinned(logs, 1).front().starts.time, logs.front().starts.time);
}

}  // namespace test_fit_starts
}  // namespace gripline::calibrate
