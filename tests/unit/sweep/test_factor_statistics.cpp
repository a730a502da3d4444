#include "sweep/factor_statistics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "config/json_file.hpp"
#include "support/sweep_rig.hpp"

namespace gripline::sweep {
namespace test_factor_statistics {

namespace fs = std::filesystem;
using namespace testing_support;
using testing::ElementsAre;

class FactorStatistics : public SweepRig {};

TEST_F(FactorStatistics, StatisticsRankTheFactorThatMakesTheDifference) {
  factors({"/base/planner/params/mu=0.3,0.4,0.5,0.6", "/world/duration=0.5,1"});
  request_.seeds = parse_seeds("1..8");
  const Sweep sweep = planned();
  body(sweep)(*missing("out", 1000), 0, [] {});
  Table table;
  merge_records(out(), sweep, table);
  const Statistics statistics = analyse(table);
  EXPECT_THAT(statistics.varying, ElementsAre("/base/planner/params/mu", "/world/duration", "stack"));
  const auto response = [&](const std::string& name) {
    return *std::find_if(statistics.responses.begin(), statistics.responses.end(),
                         [&](const ResponseStatistic& one) { return one.name == name; });
  };
  const ResponseStatistic lap = response("lap0_s"), outside = response("violation_s");
  EXPECT_EQ(lap.effects.front().factor, "/base/planner/params/mu");
  EXPECT_GT(lap.effects.front().main, 0.5);
  EXPECT_GT(lap.seeds, 0.02);
  // violation_s = mu x (1 or 2): both factors and their product, nothing from seeds or duration.
  EXPECT_NEAR(outside.seeds, 0, 1e-12);
  const FactorEffect& last = outside.effects.back();
  EXPECT_EQ(last.factor, "/world/duration");
  EXPECT_NEAR(last.total, 0, 1e-9);
  const auto stack = std::find_if(outside.effects.begin(), outside.effects.end(),
                                  [](const FactorEffect& effect) { return effect.factor == "stack"; });
  EXPECT_GT(stack->total, stack->main);
  ASSERT_FALSE(outside.best.empty());
  EXPECT_THAT(outside.best.front().levels, ElementsAre("0.3", testing::_, "slow"));
  EXPECT_NEAR(outside.best.front().median, 0.3, 1e-12);
  write_statistics(out(), sweep, {}, table, statistics);
  for (const char* name : {"factors.csv", "sensitivity.csv", "best.csv", "sweep_report.json"})
    EXPECT_TRUE(fs::exists(out() / name)) << name;
}

/// What breaks soon has had no time to leave the road.
TEST_F(FactorStatistics, RunsThatBrokeCountInFinishedAlone) {
  factors({"/base/planner/params/mu=0.3,0.4,0.5"});
  request_.only = {"slow"};
  request_.seeds = parse_seeds("1..4");
  const Sweep sweep = planned();
  const KeyFile keys(out(), sweep);
  for (std::size_t i = 0; i < sweep.size(); ++i) {
    const RunAt run = sweep.at(i);
    const bool broke = run.setting == 0;
    Record record;
    record.key = keys.key(i);
    record.status = broke ? (run.seed == 1 ? "error" : "plugin_error") : "finished";
    record.values = {{"finished", broke ? 0 : 1}, {"violation_s", broke ? 0 : static_cast<double>(run.setting)}};
    Store(out()).write(record);
  }
  Table table;
  const MergeOutcome outcome = merge_records(out(), sweep, table);
  EXPECT_EQ(outcome.broken, 4u);
  const Statistics statistics = analyse(table);
  ASSERT_EQ(statistics.responses.size(), 2u);
  const ResponseStatistic &finished = statistics.responses[0], &outside = statistics.responses[1];
  EXPECT_EQ(finished.name, "finished");
  EXPECT_EQ(finished.runs, 12u);
  EXPECT_EQ(outside.runs, 8u);
  EXPECT_THAT(outside.best.front().levels, ElementsAre("0.4"));
  EXPECT_EQ(outside.best.size(), 2u);
  write_statistics(out(), sweep, outcome, table, statistics);
  const Node report = parse_file(out() / "sweep_report.json");
  EXPECT_TRUE(report.at("lines").array().front().array().back().is_null());
  EXPECT_THAT(lines(out() / "table.csv")[1], testing::EndsWith(",error,0,0")) << "what it did is in the table";
}

/// Ten seeds of two settings; `drive` says what each run did, in digits of a hash.
class Repeats : public SweepRig {
 protected:
  template <class Drive>
  ResponseStatistic lap_of(const Drive& drive) {
    factors({"/base/planner/params/mu=0.3,0.4"});
    request_.only = {"slow"};
    request_.seeds = parse_seeds("1..10");
    const Sweep sweep = planned();
    const KeyFile keys(out(), sweep);
    for (std::size_t i = 0; i < sweep.size(); ++i) {
      const RunAt run = sweep.at(i);
      Record record;
      record.key = keys.key(i);
      record.status = "finished";
      record.values = {{"lap0_s", 1.0 + static_cast<double>(run.setting)}};
      record.drive = drive(run);
      Store(out()).write(record);
    }
    Table table;
    merge_records(out(), sweep, table);
    EXPECT_EQ(table.rows(), 20u);
    return analyse(table).responses.at(0);
  }
};

TEST_F(Repeats, RunsThatAreEqualToTheLastBitCountOnce) {
  const ResponseStatistic lap = lap_of([](const RunAt& run) { return std::string(64, run.setting == 0 ? 'a' : 'b'); });
  EXPECT_EQ(lap.runs, 2u);
  EXPECT_EQ(lap.effects.front().levels.front().runs, 1u);
  EXPECT_EQ(lap.best.at(1).runs, 1u);
  EXPECT_EQ(lap.best.at(1).p, 1.0);
}

TEST_F(Repeats, RunsThatDifferAndThoseOfWhichNothingIsKnownAllCount) {
  for (const std::string& unknown : {std::string(), std::string(56, '1')}) {
    const ResponseStatistic lap =
        lap_of([&](const RunAt& run) { return unknown.empty() ? unknown : std::to_string(10 + run.index) + unknown; });
    EXPECT_EQ(lap.runs, 20u);
    EXPECT_DOUBLE_EQ(lap.best.at(1).p, 2.0 / 1024.0);
  }
}

/// The first setting does the same under every seed and the other does not: no two pairs are equal.
TEST_F(Repeats, PairsCountWhereOneOfTheTwoDiffers) {
  const ResponseStatistic lap = lap_of([](const RunAt& run) {
    return run.setting == 0 ? std::string(64, 'a') : std::to_string(10 + run.index) + std::string(62, '1');
  });
  EXPECT_EQ(lap.runs, 11u);
  EXPECT_DOUBLE_EQ(lap.best.at(1).p, 2.0 / 1024.0);
}

/// The k-th smallest and the k-th largest of n values enclose the median unless fewer than k of them are below or
/// above: with a probability of 1 - 2 P(B < k), B binomial with n and 1/2.
double coverage(int n, int k) {
  double tail = 0.0;
  for (int below = 0; below < k; ++below)
    tail += std::exp(std::lgamma(n + 1.0) - std::lgamma(below + 1.0) - std::lgamma(n - below + 1.0) -
                     n * std::numbers::ln2);
  return 1.0 - 2.0 * tail;
}

TEST(FactorIntervals, OfManyRunsCoverTheMedianAsStatedFromBothEndsAlike) {
  for (const std::size_t n : {201U, 202U, 300U, 1000U}) {
    Table table;
    table.factors = {"/a"};
    table.levels = {{"1", "2"}};
    table.level.resize(1);
    table.responses = {"lap0_s"};
    table.value.resize(1);
    for (std::size_t row = 0; row < 2 * n; ++row) {
      table.level[0].push_back(row < n ? 0 : 1);
      table.seed.push_back(row);
      table.drive.push_back(row + 1);
      table.value[0].push_back(static_cast<double>(row % n + 1));
    }
    table.repeats.assign(2 * n, false);
    table.broken.assign(2 * n, false);
    const LevelStatistic level = analyse(table).responses.at(0).effects.at(0).levels.at(0);
    ASSERT_EQ(level.runs, n);
    EXPECT_EQ(level.lo + level.hi, static_cast<double>(n + 1));
    EXPECT_NEAR(coverage(static_cast<int>(n), static_cast<int>(level.lo)), 0.96, 0.011) << n;
  }
}

}  // namespace test_factor_statistics
}  // namespace gripline::sweep
