#include "util/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gripline {
namespace test_statistics {

const std::vector<double> odd = {30, 10, 20, 50, 40};
const std::vector<double> even = {40, 10, 30, 20};

TEST(Statistics, OrderStatisticCountsFromTheSmallest) {
  EXPECT_EQ(order_statistic(odd, 0), 10);
  EXPECT_EQ(order_statistic(odd, 3), 40);
  EXPECT_EQ(order_statistic(odd, 99), 50);
}

TEST(Statistics, MediansDifferWhenThereIsNoMiddleValue) {
  EXPECT_EQ(median(odd), 30);
  EXPECT_EQ(upper_median(odd), 30);
  EXPECT_EQ(median(even), 25);
  EXPECT_EQ(upper_median(even), 30);
  EXPECT_EQ(median({7}), 7);
}

/// Worked by hand: 4 values; definition 1 takes ceil(4 p) of them, definition 7 the rank 3 p.
TEST(Statistics, QuantilesFollowTheirDefinitions) {
  EXPECT_EQ(nearest_rank_quantile(even, 0.0), 10);
  EXPECT_EQ(nearest_rank_quantile(even, 0.5), 20);
  EXPECT_EQ(nearest_rank_quantile(even, 0.51), 30);
  EXPECT_EQ(nearest_rank_quantile(even, 1.0), 40);
  EXPECT_DOUBLE_EQ(linear_quantile(even, 0.5), 25);
  EXPECT_DOUBLE_EQ(linear_quantile(even, 0.9), 37);
  EXPECT_EQ(linear_quantile(even, 1.0), 40);
  EXPECT_EQ(lower_quantile(even, 0.5), 20);
  EXPECT_EQ(lower_quantile(even, 0.9), 30);
  EXPECT_EQ(lower_quantile(even, 1.0), 40);
}

TEST(Statistics, OfNothingIsWhatTheCallerSays) {
  EXPECT_TRUE(std::isnan(median({})));
  EXPECT_TRUE(std::isnan(nearest_rank_quantile({}, 0.5)));
  EXPECT_EQ(order_statistic({}, 0, 1), 1);
  EXPECT_EQ(upper_median({}, 2), 2);
  EXPECT_EQ(linear_quantile({}, 0.5, 3), 3);
  EXPECT_EQ(lower_quantile({}, 0.5, 4), 4);
}

}  // namespace test_statistics
}  // namespace gripline
