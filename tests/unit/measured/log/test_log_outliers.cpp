#include "measured/log/log_outliers.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/circling_session.hpp"

namespace gripline::measured {
namespace test_log_outliers {

using test::circling_session;

std::size_t dropped_of(Session s) { return drop_place_spikes(s); }

TEST(DropPlaceSpikes, SingleWildPlacesOnly) {
  Session s = circling_session(0.02);
  const Session clean = s;
  EXPECT_EQ(dropped_of(s), 0u);
  s.reading[500 * channels] += 5.0;
  s.reading[900 * channels + 1] -= 0.5;
  s.reading[1200 * channels + 3] += 5.0;                                         // a speed is no place
  for (std::size_t i = 1500; i < s.rows(); ++i) s.reading[i * channels] += 5.0;  // another zero from here on
  for (std::size_t i = 2000; i < 2010; ++i) s.reading[i * channels + 1] += 1.0;  // another satellite for a while
  ASSERT_EQ(drop_place_spikes(s), 2u);
  for (std::size_t i = 0; i < s.rows(); ++i) {
    EXPECT_EQ(std::isnan(s.at(i, 0)), i == 500) << i;
    EXPECT_EQ(std::isnan(s.at(i, 1)), i == 900) << i;
  }
  EXPECT_EQ(s.at(499, 0), clean.at(499, 0));
  EXPECT_EQ(s.rows(), clean.rows());
}

TEST(DropPlaceSpikes, ReadingsBetweenRowsWithoutOne) {
  Session s = circling_session(0.01, 4);
  s.reading[400 * channels] += 5.0;
  EXPECT_EQ(drop_place_spikes(s), 1u);
  EXPECT_TRUE(std::isnan(s.at(400, 0)));
}

TEST(DropPlaceSpikes, ASlowLogIsLeftAsItIs) {
  Session slow = circling_session(0.06);
  slow.reading[400 * channels] += 5.0;
  EXPECT_EQ(dropped_of(slow), 0u);
  Session fast = circling_session(0.058);
  fast.reading[400 * channels] += 5.0;
  EXPECT_EQ(dropped_of(fast), 1u);
}

TEST(DropPlaceSpikes, AReadingThatIsARowLateIsNone) {
  Session s = circling_session(0.02);
  for (std::size_t i = 50; i < s.rows(); i += 50)
    for (std::size_t c = 0; c < 2; ++c) s.reading[i * channels + c] = s.at(i - 1, c);
  EXPECT_EQ(dropped_of(s), 0u);
}

/// What repeats until the next fix, and rows that are missing, are no spikes.
TEST(DropPlaceSpikes, StepsAndGapsAreNone) {
  Session stairs = circling_session(0.01);
  for (std::size_t i = 0; i < stairs.rows(); ++i)
    for (std::size_t c = 0; c < 2; ++c) stairs.reading[i * channels + c] = stairs.at(i - i % 10, c);
  EXPECT_EQ(dropped_of(stairs), 0u);
  Session gaps = circling_session(0.01), kept;
  for (std::size_t i = 0; i < gaps.rows(); ++i) {
    if (i % 97 < 6) continue;
    kept.t.push_back(gaps.t[i]);
    kept.command.push_back({});
    for (std::size_t c = 0; c < channels; ++c) kept.reading.push_back(gaps.at(i, c));
  }
  EXPECT_EQ(dropped_of(kept), 0u);
}

}  // namespace test_log_outliers
}  // namespace gripline::measured
