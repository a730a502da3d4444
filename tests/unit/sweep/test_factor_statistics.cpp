#include "sweep/factor_statistics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

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

}  // namespace test_factor_statistics
}  // namespace gripline::sweep
