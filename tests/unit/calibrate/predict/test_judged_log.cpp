#include "calibrate/predict/judged_log.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/circling_session.hpp"

namespace gripline::calibrate {
namespace test_judged_log {

using measured::Channel;
using test::circling_session;

constexpr double fast = 7.9, faster = 8.1;  // [m/s] a little slower and faster than the car

/// Predictions of 0.2 and 0.4 s from starts every 0.2 s.
FitLog log_of(const Session& session) { return {session, 0.01, {0.2, 0.4}, 0.2, 0.0, FitLog::Speed::own}; }

TEST(JudgedLog, WithoutOutliersEveryStartThatIsFastEnoughCounts) {
  const Session session = circling_session(0.02);
  const FitLog log = log_of(session);
  const JudgedLog judged(log);
  EXPECT_EQ(judged.gross_outliers(), 0u);
  EXPECT_EQ(judged.place_spikes(), 0u);
  const std::size_t starts = log.starts.time.size();
  ASSERT_GT(starts, 200u);
  EXPECT_EQ(judged.counted(0, fast).start.size(), starts);
  EXPECT_TRUE(judged.counted(0, faster).start.empty());
  EXPECT_FALSE(judged.counts(0, faster));
}

TEST(JudgedLog, TruthIsThatOfTheHorizon) {
  const Session session = circling_session(0.02);
  const FitLog log = log_of(session);
  const JudgedLog judged(log);
  for (const std::size_t horizon : {0u, 1u}) {
    const CountedStarts of = judged.counted(horizon, fast);
    ASSERT_EQ(of.truth.size(), of.start.size() * channels);
    ASSERT_EQ(of.time.size(), of.start.size());
    const double yaw = 8.0 / 20.0 * (of.time[7] + log.starts.horizons[horizon]);
    EXPECT_NEAR(of.truth[7 * channels + Channel::yaw], yaw, 1e-9) << horizon;
  }
}

/// What is predicted from a wild place, or from a row soon after one, is not the model's error.
TEST(JudgedLog, StartsAtAWildPlaceOrSoonAfterDoNotCount) {
  for (const std::size_t spike : {500u, 498u, 497u, 496u}) {
    Session session = circling_session(0.02);
    session.reading[spike * channels + Channel::x] -= 10.0;
    const FitLog log = log_of(session);
    const JudgedLog judged(log);
    ASSERT_EQ(judged.place_spikes(), 1u);
    std::size_t left_out = 0;
    for (std::size_t i = 0; i < log.starts.time.size(); ++i) {
      const std::size_t row = session.row_before(log.starts.time[i] + 1e-9);
      const bool soon_after = row >= spike && row <= spike + 3;
      EXPECT_EQ(judged.counts(i, fast), !soon_after) << spike << " " << row;
      left_out += soon_after;
    }
    EXPECT_EQ(left_out, spike == 496 ? 0u : 1u);  // rows 490, 500, 510 are starts
  }
}

TEST(JudgedLog, NoPredictionIsComparedWithAWildPlace) {
  Session session = circling_session(0.02);
  session.reading[500 * channels + Channel::x] -= 10.0;
  const FitLog log = log_of(session);
  const JudgedLog judged(log);
  double as_read = 0.0, without = 0.0;
  for (std::size_t k = Channel::x; k < log.truth.size(); k += channels) {
    if (std::isfinite(log.truth[k])) as_read = std::min(as_read, log.truth[k]);
    if (std::isfinite(judged.log().truth[k])) without = std::min(without, judged.log().truth[k]);
  }
  EXPECT_LT(as_read, -24.0);
  EXPECT_GT(without, -20.1);
  EXPECT_EQ(session.at(500, Channel::x), log.session->at(500, Channel::x));  // what was read stays
}

}  // namespace test_judged_log
}  // namespace gripline::calibrate
