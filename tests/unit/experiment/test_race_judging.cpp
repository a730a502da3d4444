#include "experiment/race_judging.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "experiment/race_printing.hpp"
#include "support/race_sample.hpp"

namespace gripline {
namespace test_race_judging {

using testing::HasSubstr;
using namespace testing_support;

/// The limit at factor 0.75 is 7.5 s in this world.
TEST(RaceJudging, ALimitThatIsBeatenInsideTheRoadIsNone) {
  const RaceSpec race = race_of();
  std::vector<RunResult> runs = {run_of("none", 1, 0, {9, 7.6}), run_of("elm", 1, 0, {7, 7.4}),
                                 run_of("elm", 2, 0.02, {9, 7.0})};
  const RaceResults results = {race, runs, {"none", "elm"}};
  const std::vector<std::string> beaten = beaten_limits(results);
  ASSERT_EQ(beaten.size(), 1u);  // lap 0 is no flying lap, and seed 2 left the road
  EXPECT_EQ(beaten[0],
            "elm, seed 1: lap 1 took 7.400 s inside the road, the limit is 7.500 s with an error of 0.000 s");
  std::ostringstream out;
  print_tables(out, results, {});
  EXPECT_THAT(out.str(), HasSubstr("the stated limit is too slow: elm, seed 1"));
}

/// A lap after a drop of friction begins faster than one that is driven on that friction alone.
TEST(RaceJudging, ALapThatBeginsOnBetterFrictionMayBeFasterThanTheLimit) {
  const RaceSpec race = race_of();
  std::vector<RunResult> runs = {run_of("none", 1, 0, {9, 7.4}), run_of("elm", 1, 0, {9, 7.4})};
  runs[0].summary.lap_mean_factors[0] = runs[0].summary.lap_mean_factors[1] + 0.06;
  runs[1].summary.lap_mean_factors[0] = runs[1].summary.lap_mean_factors[1] + 0.04;
  const std::vector<std::string> beaten = beaten_limits({race, runs, {"none", "elm"}});
  ASSERT_EQ(beaten.size(), 1u);
  EXPECT_THAT(beaten[0], HasSubstr("elm"));
}

/// Laps of 7.6 s: a corner of elm was outside, which the limit of 7.7 s for the whole car says nothing about.
TEST(RaceJudging, TheLimitWithTheWholeCarInsideIsForRunsThatKeptItSo) {
  RaceSpec race = race_of();
  race.world.time_optimal_body.laps = {{0.5, 8.2}, {1.0, 7.2}};
  race.world.time_optimal_body.error = 0.05;
  std::vector<RunResult> runs = {run_of("none", 1, 0, {9, 7.6}), run_of("none", 2, 0, {9, 7.66}),
                                 run_of("elm", 1, 0, {9, 7.6})};
  runs[2].summary.violation_body_s = 0.02;
  const std::vector<std::string> beaten = beaten_limits({race, runs, {"none", "elm"}});
  ASSERT_EQ(beaten.size(), 1u);
  EXPECT_EQ(beaten[0],
            "none, seed 1: lap 1 took 7.600 s with the whole car inside the road, the limit is 7.700 s with an error "
            "of 0.050 s");
}

TEST(RaceJudging, ClaimsOnTimesNeedTheMachineAlone) {
  const RaceSpec race = race_of(R"(["elm.solve_ms_median < none.solve_ms_median", "elm.lap0_s < none.lap0_s"])");
  RaceResults results = {race, some_runs(), {"none", "elm", "oracle"}};
  results.runs.back().timing.alone = false;  // oracle's, which no claim names
  EXPECT_TRUE(judge_all(results)[0].holds.has_value());
  results.runs[1].timing.alone = false;  // one of none's three
  const std::vector<ClaimResult> shared = judge_all(results);
  EXPECT_FALSE(shared[0].holds.has_value());
  EXPECT_EQ(shared[0].why_skipped, "on times: needs -j 1");
  EXPECT_TRUE(shared[1].holds.value());
}

/// A lost run was measured neither alone nor beside others: the claim is about times that are not there.
TEST(RaceJudging, AClaimOnTheTimesOfALostRunDoesNotHold) {
  const RaceSpec race = race_of(R"(["elm.solve_ms_median < none.solve_ms_median"])", 1);
  RunResult lost;
  lost.summary.stack = "elm";
  EXPECT_FALSE(judge_all({race, {run_of("none", 1, 3, {8, 9}), lost}, {"none", "elm"}}).at(0).holds.value());
}

}  // namespace test_race_judging
}  // namespace gripline
