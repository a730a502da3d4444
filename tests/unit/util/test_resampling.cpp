#include "util/resampling.hpp"

#include <gtest/gtest.h>

#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <numeric>
#include <random>
#include <utility>

#include "util/statistics.hpp"

namespace gripline {
namespace test_resampling {

TEST(Resampling, IntervalHoldsTheMedianAndOnlyValuesThatCanOccur) {
  const std::vector<double> values = {3, 1, 2, 5, 4, 9, 7, 8, 6};
  const MedianInterval i = bootstrap_median_interval(values);
  EXPECT_LE(i.lo, 5);
  EXPECT_GE(i.hi, 5);
  EXPECT_GE(i.lo, 1);
  EXPECT_LE(i.hi, 9);
  EXPECT_LT(i.lo, i.hi);
  // The exact bootstrap distribution of the median of nine: P(<= third smallest) = 0.028 to 0.05, so that the ends are
  // the third of either side or a neighbour of it.
  EXPECT_NEAR(i.lo, 3, 1);
  EXPECT_NEAR(i.hi, 7, 1);
}

TEST(Resampling, SameValuesInAnyOrderGiveTheSameInterval) {
  const MedianInterval a = bootstrap_median_interval({1, 2, 3, 4.5, 6}),
                       b = bootstrap_median_interval({6, 4.5, 3, 2, 1});
  EXPECT_EQ(a.lo, b.lo);
  EXPECT_EQ(a.hi, b.hi);
}

TEST(Resampling, OneValueHasNoInterval) {
  EXPECT_TRUE(std::isnan(bootstrap_median_interval({}).lo));
  EXPECT_TRUE(std::isnan(bootstrap_median_interval({7}).hi));
  EXPECT_EQ(bootstrap_median_interval({7, 7}).lo, 7);
}

/// Over many samples of a known distribution the interval holds the true median about as often as it says.
TEST(Resampling, CoversTheTrueMedianAsOftenAsStated) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(2.0, 1.0);
  int held = 0;
  constexpr int trials = 300;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<double> values(25);
    for (double& one : values) one = normal(random);
    const MedianInterval i = bootstrap_median_interval(values);
    held += i.lo <= 2.0 && 2.0 <= i.hi ? 1 : 0;
  }
  EXPECT_GT(held, 0.90 * trials);
  EXPECT_LT(held, 0.995 * trials);
}

/// Of an odd number of values the ends are two of them, and how often they enclose the median is a binomial sum: what
/// the header and metrics.md state.
TEST(Resampling, CoversAsStatedOfFewValues) {
  const std::pair<std::size_t, double> stated[] = {{7, 0.875},  {9, 0.961},  {11, 0.935}, {13, 0.908}, {15, 0.882},
                                                   {17, 0.951}, {19, 0.936}, {21, 0.922}, {25, 0.957}};
  for (const auto& [n, share] : stated) {
    std::vector<double> ranks(n);
    std::iota(ranks.begin(), ranks.end(), 1.0);
    const MedianInterval i = bootstrap_median_interval(ranks);
    const boost::math::binomial_distribution<double> below(static_cast<double>(n), 0.5);  // values below the median
    EXPECT_NEAR(cdf(below, i.hi - 1) - cdf(below, i.lo - 1), share, 5e-4) << n;
  }
}

/// So tables may call it a range.
TEST(Resampling, BelowTheLeastForAnIntervalItIsTheRange) {
  std::vector<double> values;
  for (std::size_t n = 2; n <= least_for_interval; ++n) {
    values.clear();
    for (std::size_t i = 0; i < n; ++i) values.push_back(static_cast<double>(i * i));
    const MedianInterval i = bootstrap_median_interval(values);
    const bool range = i.lo == values.front() && i.hi == values.back();
    EXPECT_EQ(range, n < least_for_interval) << n;
  }
}

TEST(Resampling, TheLeastPIsThatOfOneSign) {
  std::vector<double> differences;
  for (std::size_t n = 0; n < 9; ++n, differences.push_back(1))
    EXPECT_DOUBLE_EQ(least_sign_test(n), sign_test(differences)) << n;
}

TEST(Resampling, SignTestIsTheBinomialTail) {
  EXPECT_DOUBLE_EQ(sign_test(std::vector<double>{1, 1, 1, 1, 1}), 2.0 / 32.0);
  EXPECT_DOUBLE_EQ(sign_test(std::vector<double>{-1, -2, -3, -4, 5}), 2.0 * 6.0 / 32.0);
  EXPECT_DOUBLE_EQ(sign_test(std::vector<double>{0, 0, 1, -1}), 1.0);  // zeros say nothing
  EXPECT_DOUBLE_EQ(sign_test(std::vector<double>{0, 0}), 1.0);
  EXPECT_DOUBLE_EQ(sign_test({}), 1.0);
}

}  // namespace test_resampling
}  // namespace gripline
