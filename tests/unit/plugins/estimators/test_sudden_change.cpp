#include "estimators/elm_rls/sudden_change.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace gripline::elm_rls {
namespace test_sudden_change {

constexpr double dt = 0.02;  // [s]

/// Samples until an alarm, at most `most`, with forces of both signs whose true scale is 1 + `change`.
int samples_until_alarm(double alarm, double change, int most = 200) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  SuddenChange test(alarm);
  for (int i = 0; i < most; ++i) {
    const double force = i % 20 < 10 ? 6.0 : -6.0;
    const SuddenChange::Rate rates[] = {{change * force + normal(random), 1.0, force}, {normal(random), 1.0, 0.0}};
    test.add(rates, dt);
    if (test.alarms()) return i;
  }
  return most;
}

TEST(SuddenChange, AlarmsSoonAfterForcesChangedInScaleAndNotUnderNoise) {
  EXPECT_LT(samples_until_alarm(4.5, -0.35), 15);
  EXPECT_LT(samples_until_alarm(4.5, 0.35), 15);
  EXPECT_EQ(samples_until_alarm(4.5, 0.0), 200);
  EXPECT_GT(samples_until_alarm(9.0, -0.35), samples_until_alarm(4.5, -0.35));
}

TEST(SuddenChange, ScoreIsInStandardDeviations) {
  const SuddenChange::Rate rates[] = {{1.9, 4.0, 3.0}, {1.9, 4.0, 3.0}};  // e F / V over sqrt(F^2 / V): 0.95 each
  SuddenChange below(1.35), above(1.34);                                  // 0.95 sqrt(2) = 1.3435
  below.add(rates, dt);
  above.add(rates, dt);
  EXPECT_FALSE(below.alarms());
  EXPECT_TRUE(above.alarms());
}

TEST(SuddenChange, OldSamplesCountLess) {
  SuddenChange test(1.0);
  const SuddenChange::Rate surprising[] = {{3.0, 1.0, 1.0}}, expected[] = {{0.0, 1.0, 1.0}};
  test.add(surprising, dt);
  EXPECT_TRUE(test.alarms());
  for (int i = 0; i < 20; ++i) test.add(expected, dt);
  EXPECT_FALSE(test.alarms());
}

// A tenth is forgotten in 20 ms, whatever a step lasts: 9 fades to 1 in 0.42 s.
TEST(SuddenChange, RemembersAsLongAtAnyStep) {
  const auto samples_of_alarm = [](double step) {
    SuddenChange test(1.0);
    const SuddenChange::Rate surprising[] = {{3.0, 1.0, 1.0}}, silent[] = {{0.0, 1.0, 0.0}};
    test.add(surprising, step);
    int samples = 0;
    for (; test.alarms(); ++samples) test.add(silent, step);
    return samples;
  };
  EXPECT_EQ(samples_of_alarm(0.01), 42);
  EXPECT_EQ(samples_of_alarm(0.02), 21);
  EXPECT_EQ(samples_of_alarm(0.04), 11);
}

TEST(SuddenChange, TestsLargeSideForcesOnly) {
  EXPECT_TRUE(SuddenChange::tests(0.41 * gravity, 1.0, 1.2));
  EXPECT_FALSE(SuddenChange::tests(0.39 * gravity, 1.0, 1.2));
  EXPECT_TRUE(SuddenChange::tests(0.39 * gravity, 1.2, 0.9));
}

TEST(SuddenChange, IsRecentForHalfASecondAndBeginsANewScore) {
  SuddenChange test(1.0);
  EXPECT_FALSE(test.recent());
  const SuddenChange::Rate rates[] = {{3.0, 1.0, 1.0}};
  test.add(rates, dt);
  test.begin_change();
  EXPECT_FALSE(test.alarms());
  test.pass(0.49);
  EXPECT_TRUE(test.recent());
  test.pass(0.02);
  EXPECT_FALSE(test.recent());
}

TEST(SuddenChange, BreakEndsTheChangeAndKeepsTheScore) {
  SuddenChange test(1.0);
  test.begin_change();
  const SuddenChange::Rate rates[] = {{3.0, 1.0, 1.0}};
  test.add(rates, dt);
  test.break_sequence();
  EXPECT_FALSE(test.recent());
  EXPECT_TRUE(test.alarms());
  test.start_over();
  EXPECT_FALSE(test.alarms());
}

// Otherwise no change would be found after one sample of a sensor that fails.
TEST(SuddenChange, ScoreThatIsNoNumberIsAnAlarmAndEndsWithIt) {
  SuddenChange test(4.5);
  const SuddenChange::Rate rates[] = {{std::nan(""), 1.0, 1.0}};
  test.add(rates, dt);
  EXPECT_TRUE(test.alarms());
  test.begin_change();
  EXPECT_FALSE(test.alarms());
}

}  // namespace test_sudden_change
}  // namespace gripline::elm_rls
