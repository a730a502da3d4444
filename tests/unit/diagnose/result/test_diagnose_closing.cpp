#include "diagnose/result/closing.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gripline::diagnose {
namespace test_diagnose_closing {

constexpr double ample = 100.0, little = 5.0;  // log evidence

/// An error of 2 without the effect, and what it is with it; significantly so: the interval is a tenth of the change.
Gap gap_to(double after, bool significant) {
  Gap gap{1.0, 2.0, after};
  const double change = after / 2.0 - 1.0;
  gap.change = {change, change - 0.1 * std::abs(change), change + 0.1 * std::abs(change)};
  if (!significant) gap.change.low = -1.0, gap.change.high = 1.0;
  gap.closure = significant && change < 0.0 ? 0.5 : 0.0;
  return gap;
}

TEST(DiagnoseClosing, AGapThatClosesIsEnough) {
  for (const bool moved : {false, true}) EXPECT_EQ(closing(gap_to(1.5, true), little, moved), Closing::closes);
}

/// A road that moves the car makes errors smaller by chance.
TEST(DiagnoseClosing, WhereNoiseMovesTheCarChanceIsNotEnough) {
  EXPECT_EQ(closing(gap_to(1.9, false), little, false), Closing::closes);
  EXPECT_EQ(closing(gap_to(1.9, false), little, true), Closing::remains_open);
  EXPECT_EQ(closing(gap_to(1.9, false), ample, true), Closing::inconclusive);
}

/// What has ample evidence and rests on the laps held out is decided on the others; what makes them worse is not.
/// Such noise also makes errors larger by chance.
TEST(DiagnoseClosing, AmpleEvidenceIsDecidedOnFittedDataUnlessPredictionsAreWorse) {
  EXPECT_EQ(closing(gap_to(2.0, false), ample, false), Closing::inconclusive);
  EXPECT_EQ(closing(gap_to(2.0, false), little, false), Closing::remains_open);
  EXPECT_EQ(closing(gap_to(2.02, false), ample, false), Closing::remains_open);
  EXPECT_EQ(closing(gap_to(2.02, false), ample, true), Closing::inconclusive);
  EXPECT_EQ(closing(gap_to(2.02, true), ample, true), Closing::remains_open);
}

TEST(DiagnoseClosing, FittedDataMustGetSignificantlyBetterWhereNoiseMovesTheCar) {
  EXPECT_TRUE(closes_on_training({-0.1, -0.3, 0.1}, false));
  EXPECT_FALSE(closes_on_training({-0.1, -0.3, 0.1}, true));
  EXPECT_TRUE(closes_on_training({-0.1, -0.15, -0.05}, true));
  for (const bool moved : {false, true}) EXPECT_FALSE(closes_on_training({0.1, 0.05, 0.15}, moved));
}

}  // namespace test_diagnose_closing
}  // namespace gripline::diagnose
