#include "planners/time_optimal/trial_filter.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace gripline::time_optimal {
namespace test_trial_filter {

TrialFilter fresh(double most_violation = 10.0) {
  TrialFilter filter;
  filter.clear(most_violation);
  return filter;
}

TEST(TrialFilter, TakesWhatViolatesLessOrHasALowerObjective) {
  EXPECT_TRUE(fresh().take({1.0, 5.0}, {0.5, 9.0}));
  EXPECT_TRUE(fresh().take({1.0, 5.0}, {3.0, 4.0}));
  EXPECT_FALSE(fresh().take({1.0, 5.0}, {1.5, 6.0}));
  EXPECT_FALSE(fresh().take({1.0, 5.0}, {1.0, 5.0}));
}

TEST(TrialFilter, TakesNothingThatViolatesMoreThanTheMost) {
  EXPECT_FALSE(fresh(2.0).take({1.0, 5.0}, {2.5, -100.0}));
  EXPECT_TRUE(fresh(2.0).take({1.0, 5.0}, {1.9, -100.0}));
}

// Without memory a search may go round in circles between few violations and a low objective.
TEST(TrialFilter, DoesNotGoBack) {
  TrialFilter filter = fresh();
  EXPECT_TRUE(filter.take({1.0, 5.0}, {3.0, 4.0}));
  EXPECT_TRUE(filter.take({3.0, 4.0}, {0.9, 6.0}));
  EXPECT_FALSE(filter.take({0.9, 6.0}, {3.0, 4.5}));
  EXPECT_FALSE(filter.take({0.9, 6.0}, {1.0, 5.0}));
  EXPECT_TRUE(filter.take({0.9, 6.0}, {0.8, 6.5}));
}

TEST(TrialFilter, ForgetsWhenClearedAndTheOldestWhenFull) {
  TrialFilter filter = fresh();
  EXPECT_TRUE(filter.take({1.0, 5.0}, {3.0, 4.0}));
  filter.clear(10.0);
  EXPECT_TRUE(filter.take({0.9, 6.0}, {1.0, 5.0}));
  filter.clear(10.0);
  double violation = 8.0;  // each point violates less, for a higher objective
  for (int i = 0; i < 100; ++i, violation *= 0.9)
    EXPECT_TRUE(filter.take({violation, static_cast<double>(i)}, {0.9 * violation, i + 1.0}));
  EXPECT_TRUE(filter.take({violation, 100.0}, {8.5, 0.5}));  // worse than the first alone
}

TEST(TrialFilter, RefusesWhatIsNotANumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(fresh().take({1.0, 5.0}, {nan, 1.0}));
  EXPECT_FALSE(fresh().take({1.0, 5.0}, {0.5, nan}));
  EXPECT_FALSE(fresh().take({1.0, 5.0}, {0.5, -std::numeric_limits<double>::infinity()}));
}

}  // namespace test_trial_filter
}  // namespace gripline::time_optimal
