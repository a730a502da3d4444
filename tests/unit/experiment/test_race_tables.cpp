#include "experiment/race_tables.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "support/comma_locale.hpp"
#include "support/host_support.hpp"

namespace gripline {
namespace test_race_tables {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using namespace testing_support;

/// A race of JSON stacks with the world's own lap table.
RaceSpec race_of(const char* claims = "[]", int seeds = 3) {
  Node world = merge(small_world(), json(R"({"duration": null, "laps": 2, "timeout": 9,
    "time_optimal_laps": [{"factor": 0.5, "lap": 8}, {"factor": 1, "lap": 7}]})"));
  inline_world_files(world);
  Node tree = json(R"({"base": {"model": {"plugin": "ekinematic"}, "planner": {"plugin": "fixed_speed"},
    "controller": {"plugin": "pure_pursuit"}}, "stacks": {"none": {}, "elm": {}, "oracle": {"estimator": {"plugin": "oracle"}}}})");
  tree.set("world", world);
  tree.set("claims", json(claims));
  Node count{Node::Object{}};
  count.set("count", Node(seeds));
  tree.set("seeds", count);
  return read_race("table.json", tree, plugins());
}

RunResult run_of(const std::string& stack, std::uint64_t seed, double violation, std::vector<double> laps) {
  RunResult run;
  run.summary.stack = stack;
  run.summary.seed = seed;
  run.summary.status = Status::finished;
  run.summary.laps = std::move(laps);
  run.summary.lap_mean_factors.assign(run.summary.laps.size(), 0.75);
  run.summary.violation_s = violation;
  run.summary.mean_deviation_m = 0.1 * violation;
  run.summary.steps = 100;
  run.summary.simulated_s = 2;
  run.timing.solve_ms_median = 1.5 + violation;
  run.timing.cpu_s = 0.25;
  run.timing.alone = true;
  return run;
}

/// elm: three runs of which one is a crash; none: three runs, one that drove no second lap; oracle: told the truth.
std::vector<RunResult> some_runs() {
  std::vector<RunResult> runs = {run_of("none", 1, 3, {8, 9}), run_of("none", 2, 5, {8.5}),
                                 run_of("none", 3, 4, {9, 7}), run_of("elm", 1, 1, {7.5, 7.25}),
                                 run_of("elm", 2, 2, {7, 7}),  run_of("elm", 3, 6, {7.2, 7})};
  runs[5].summary.status = Status::crashed;
  runs[4].summary.violation_after_adapt_s = 0.5;
  runs[5].summary.violation_after_adapt_s = 1.5;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    runs.push_back(run_of("oracle", seed, 0, {7, 7}));
    runs.back().summary.needs_truth = true;
  }
  return runs;
}

std::map<std::string, std::string> cells(const std::filesystem::path& file, const std::string& begins) {
  const std::vector<std::string> all = lines(file);
  std::map<std::string, std::string> found;
  for (const std::string& line : all) {
    if (line.rfind(begins, 0) != 0) continue;
    std::stringstream names(all[0]), values(line);
    for (std::string name; std::getline(names, name, ',');) {
      std::string value;
      std::getline(values, value, ',');
      found[name] = value;
    }
  }
  return found;
}

/// framework/doc/output.md.
TEST(RaceTables, HaveTheDefinedColumns) {
  const Folder folder;
  const RaceSpec race = race_of();
  write_tables(folder.path(), {race, some_runs(), {"none", "elm", "oracle"}}, {});
  const std::string measured =
      "lap0_s,lap1_s,lap0_mean_factor,lap1_mean_factor,mean_deviation_m,violation_s,violation_body_s,"
      "violation_after_adapt_s,violation_body_after_adapt_s,mu_rmse,mu_visited_rmse,solve_ms_median,solve_ms_p95,"
      "solve_ms_p99,update_ms_median,plan_latency_s,solver_failures,steps,cpu_s,simulated_s";
  EXPECT_EQ(lines(folder / "runs.csv").at(0), "stack,seed,status,needs_truth," + measured);
  EXPECT_EQ(lines(folder / "table.csv").at(0), "stack,needs_truth," + measured +
                                                   ",runs,finished,crashed,violation_s_max,violation_after_adapt_s_max,"
                                                   "pace_ratio0,pace_ratio1,body_pace_ratio0,body_pace_ratio1,seeds," +
                                                   "lap0_s_lo,lap0_s_hi,lap1_s_lo,lap1_s_hi,mean_deviation_m_lo,"
                                                   "mean_deviation_m_hi,violation_s_lo,violation_s_hi,"
                                                   "violation_body_s_lo,violation_body_s_hi,violation_after_adapt_s_lo,"
                                                   "violation_after_adapt_s_hi,violation_body_after_adapt_s_lo,"
                                                   "violation_body_after_adapt_s_hi,mu_rmse_lo,mu_rmse_hi,"
                                                   "mu_visited_rmse_lo,mu_visited_rmse_hi,solve_ms_median_lo,"
                                                   "solve_ms_median_hi,solve_ms_p95_lo,solve_ms_p95_hi,"
                                                   "solve_ms_p99_lo,solve_ms_p99_hi,update_ms_median_lo,"
                                                   "update_ms_median_hi,"
                                                   "pace_ratio0_lo,pace_ratio0_hi,pace_ratio1_lo,pace_ratio1_hi,"
                                                   "body_pace_ratio0_lo,body_pace_ratio0_hi,body_pace_ratio1_lo,"
                                                   "body_pace_ratio1_hi");
  EXPECT_EQ(lines(folder / "runs.csv").size(), 10u);
  EXPECT_EQ(lines(folder / "table.csv").size(), 4u);
}

TEST(RaceTables, RunsAreRowsWithBareNamesAndEmptyCells) {
  const Folder folder;
  const RaceSpec race = race_of();
  write_tables(folder.path(), {race, some_runs(), {"none", "elm", "oracle"}}, {});
  auto row = cells(folder / "runs.csv", "none,2,");
  EXPECT_EQ(row["status"], "finished");
  EXPECT_EQ(row["needs_truth"], "0");
  EXPECT_EQ(row["lap0_s"], "8.5");
  EXPECT_EQ(row["lap1_s"], "");  // not driven
  EXPECT_EQ(row["violation_s"], "5");
  EXPECT_EQ(row["violation_after_adapt_s"], "");  // never trusted
  EXPECT_EQ(row["cpu_s"], "0.25");
  row = cells(folder / "runs.csv", "oracle,1,");
  EXPECT_EQ(row["stack"], "oracle");
  EXPECT_EQ(row["needs_truth"], "1");
  EXPECT_EQ(cells(folder / "runs.csv", "elm,3,")["status"], "crashed");
}

TEST(RaceTables, TableIsMediansCountsMaximaAndSums) {
  const Folder folder;
  const RaceSpec race = race_of();
  write_tables(folder.path(), {race, some_runs(), {"none", "elm", "oracle"}}, {});
  auto none = cells(folder / "table.csv", "none,"), elm = cells(folder / "table.csv", "elm,");
  EXPECT_EQ(none["lap0_s"], "8.5");
  EXPECT_EQ(none["lap1_s"], "8");  // of the two that drove it
  EXPECT_EQ(none["violation_s"], "4");
  EXPECT_EQ(none["violation_s_max"], "5");
  EXPECT_EQ(none["violation_after_adapt_s_max"], "");
  EXPECT_EQ(elm["violation_after_adapt_s"], "1");
  EXPECT_EQ(elm["violation_after_adapt_s_max"], "1.5");
  EXPECT_EQ(elm["runs"], "3");
  EXPECT_EQ(elm["finished"], "2");
  EXPECT_EQ(elm["crashed"], "1");
  EXPECT_EQ(elm["cpu_s"], "0.75");
  EXPECT_EQ(elm["simulated_s"], "6");
  EXPECT_EQ(elm["lap0_mean_factor"], "0.75");
  EXPECT_DOUBLE_EQ(std::stod(none["pace_ratio0"]), 8.5 / 7.5);  // the time-optimal lap at factor 0.75 takes 7.5 s
}

TEST(RaceTables, MediansHaveIntervals) {
  const Folder folder;
  const RaceSpec race = race_of();
  write_tables(folder.path(), {race, some_runs(), {"none", "elm", "oracle"}}, {});
  auto none = cells(folder / "table.csv", "none,");
  EXPECT_EQ(none["violation_s_lo"], "3");  // of three runs all there is to say: their range
  EXPECT_EQ(none["violation_s_hi"], "5");
  EXPECT_EQ(none["seeds"], "3");
  EXPECT_EQ(none["mu_rmse_lo"], "");
  const RaceSpec one = race_of("[]", 1);
  write_tables(folder.path(), {one, {run_of("none", 1, 3, {8})}, {"none"}}, {});
  EXPECT_EQ(cells(folder / "table.csv", "none,")["violation_s_lo"], "");  // one run has none
}

TEST(RaceTables, RunsEqualToTheLastBitCountOnce) {
  const Folder folder;
  const RaceSpec race = race_of(R"(["elm.violation_s <= 2", "elm.violation_s_hi <= 2.5"])");
  std::vector<RunResult> runs = {run_of("elm", 1, 1, {8, 9}), run_of("elm", 2, 1, {8, 9}), run_of("elm", 3, 2, {9, 9})};
  runs[0].drive = runs[1].drive = "a";
  runs[2].drive = "b";
  const RaceResults results = {race, runs, {"elm"}};
  const std::vector<ClaimResult> claims = judge_all(results);
  write_tables(folder.path(), results, claims);
  auto elm = cells(folder / "table.csv", "elm,");
  EXPECT_EQ(elm["violation_s"], "1.5");
  EXPECT_EQ(elm["runs"], "2");
  EXPECT_EQ(elm["finished"], "2");
  EXPECT_EQ(elm["seeds"], "3");
  EXPECT_EQ(elm["simulated_s"], "6");  // what was driven all the same
  EXPECT_EQ(claims[0].runs, 2);
  EXPECT_EQ(claims[1].runs, 0);  // an interval has no single runs
  EXPECT_TRUE(claims[1].holds.value());
  std::ostringstream out;
  print_tables(out, results, claims);
  EXPECT_THAT(out.str(), HasSubstr("elm: seeds 1, 2 drove the same run to the last bit, which counts once"));
  EXPECT_THAT(out.str(), HasSubstr("1.00..2.00"));
  EXPECT_THAT(out.str(), HasSubstr("2/2 finished"));
}

/// A run that was not driven again cost nothing, and counts for as much as the one that it is.
TEST(RaceTables, RunsThatWereSparedCostNothing) {
  const Folder folder;
  const RaceSpec race = race_of(R"(["elm.violation_s <= 2"])");
  std::vector<RunResult> runs = {run_of("elm", 1, 1, {8, 9}), run_of("elm", 2, 1, {8, 9}), run_of("elm", 3, 1, {8, 9})};
  for (RunResult& run : runs) run.drive = "a";
  runs[2].driven_as = 1;
  const RaceResults results = {race, runs, {"elm"}};
  write_tables(folder.path(), results, {});
  auto elm = cells(folder / "table.csv", "elm,");
  EXPECT_EQ(elm["runs"], "1");
  EXPECT_EQ(elm["seeds"], "2");
  EXPECT_EQ(elm["cpu_s"], "0.5");
  EXPECT_EQ(elm["simulated_s"], "4");
  EXPECT_EQ(cells(folder / "runs.csv", "elm,3,")["violation_s"], "1");
  std::ostringstream out;
  print_tables(out, results, judge_all(results));
  EXPECT_THAT(out.str(), HasSubstr("elm: seeds 1, 2 drove the same run to the last bit, which counts once; 3 would too "
                                   "and were not driven"));
  EXPECT_THAT(out.str(), HasSubstr("warning: a claim rests on one run;"));
}

TEST(RaceTables, FailedSolvesAreASum) {
  const Folder folder;
  const RaceSpec race = race_of(R"(["elm.violation_s <= 2"])");
  std::vector<RunResult> runs = some_runs();
  runs[3].summary.solver_failures = 4, runs[5].summary.solver_failures = 3;
  const RaceResults results = {race, runs, {"none", "elm", "oracle"}};
  write_tables(folder.path(), results, {});
  EXPECT_EQ(cells(folder / "table.csv", "elm,")["solver_failures"], "7");
  EXPECT_EQ(cells(folder / "table.csv", "none,")["solver_failures"], "0");
  std::ostringstream out;
  print_tables(out, results, judge_all(results));
  EXPECT_THAT(out.str(), Not(HasSubstr("rests on one run")));
}

/// The limit at factor 0.75 is 7.5 s in this world.
TEST(RaceTables, ALimitThatIsBeatenInsideTheRoadIsNone) {
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
TEST(RaceTables, ALapThatBeginsOnBetterFrictionMayBeFasterThanTheLimit) {
  const RaceSpec race = race_of();
  std::vector<RunResult> runs = {run_of("none", 1, 0, {9, 7.4}), run_of("elm", 1, 0, {9, 7.4})};
  runs[0].summary.lap_mean_factors[0] = runs[0].summary.lap_mean_factors[1] + 0.06;
  runs[1].summary.lap_mean_factors[0] = runs[1].summary.lap_mean_factors[1] + 0.04;
  const std::vector<std::string> beaten = beaten_limits({race, runs, {"none", "elm"}});
  ASSERT_EQ(beaten.size(), 1u);
  EXPECT_THAT(beaten[0], HasSubstr("elm"));
}

/// Laps of 7.6 s: a corner of elm was outside, which the limit of 7.7 s for the whole car says nothing about.
TEST(RaceTables, TheLimitWithTheWholeCarInsideIsForRunsThatKeptItSo) {
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

TEST(RaceTables, OnlyTheRowsAskedFor) {
  const Folder folder;
  const RaceSpec race = race_of(R"(["elm.violation_s <= none.violation_s", "elm.violation_s <= 3"])");
  std::vector<RunResult> runs = some_runs();
  runs.erase(runs.begin(), runs.begin() + 3);
  const RaceResults results = {race, runs, {"elm", "oracle"}};
  const std::vector<ClaimResult> claims = judge_all(results);
  ASSERT_EQ(claims.size(), 2u);
  EXPECT_FALSE(claims[0].holds.has_value());
  EXPECT_EQ(claims[0].why_skipped, "a row was left out by --only");
  EXPECT_EQ(claims[1].runs_held, 2);
  EXPECT_FALSE(claims[1].holds.value());  // two of three are fewer than 80 %
  write_tables(folder.path(), results, claims);
  EXPECT_TRUE(cells(folder / "table.csv", "none,").empty());
  const Node written = parse_file(folder / "claims.json");
  EXPECT_EQ(written.find("skipped")->array().at(0).find("text")->text(), "elm.violation_s <= none.violation_s");
  EXPECT_EQ(written.find("claims")->array().at(0).find("holds")->boolean(), false);
  EXPECT_EQ(find_pointer(written, "/claims/0/values/left")->number(), 2);
  EXPECT_EQ(find_pointer(written, "/claims/0/values/right")->number(), 3);
}

TEST(RaceTables, ClaimsOnTimesNeedTheMachineAlone) {
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
TEST(RaceTables, AClaimOnTheTimesOfALostRunDoesNotHold) {
  const RaceSpec race = race_of(R"(["elm.solve_ms_median < none.solve_ms_median"])", 1);
  RunResult lost;
  lost.summary.stack = "elm";
  EXPECT_FALSE(judge_all({race, {run_of("none", 1, 3, {8, 9}), lost}, {"none", "elm"}}).at(0).holds.value());
}

/// A run whose process was lost has no zeros to its credit.
TEST(RaceTables, ALostRunMeasuredNothing) {
  const Folder folder;
  const RaceSpec race = race_of(R"(["elm.violation_s <= none.violation_s"])", 1);
  RunResult lost;
  lost.summary.stack = "elm";
  lost.summary.status = Status::error;
  const RaceResults results = {race, {run_of("none", 1, 3, {8, 9}), lost}, {"none", "elm"}};
  write_tables(folder.path(), results, {});
  auto row = cells(folder / "table.csv", "elm,");
  EXPECT_EQ(row["violation_s"], "");
  EXPECT_EQ(row["mean_deviation_m"], "");
  EXPECT_EQ(row["runs"], "1");
  EXPECT_EQ(row["finished"], "0");
  EXPECT_FALSE(judge_all(results).at(0).holds.value());
}

/// A planner may follow no line.
TEST(RaceTables, ARowWithoutDeviationHasAnEmptyCellAndNoClaimOnItHolds) {
  const Folder folder;
  const RaceSpec race = race_of(R"(["elm.mean_deviation_m <= 1", "elm.mean_deviation_m_hi <= 1",
                                    "none.mean_deviation_m <= 1"])");
  RaceResults results = {race, some_runs(), {"none", "elm", "oracle"}};
  for (std::size_t i = 3; i < 6; ++i) results.runs[i].summary.mean_deviation_m.reset();
  const std::vector<ClaimResult> claims = judge_all(results);
  EXPECT_FALSE(claims[0].holds.value());
  EXPECT_FALSE(claims[0].left.has_value());
  EXPECT_FALSE(claims[1].holds.value());
  EXPECT_TRUE(claims[2].holds.value());
  write_tables(folder.path(), results, claims);
  auto row = cells(folder / "table.csv", "elm,");
  for (const char* column : {"mean_deviation_m", "mean_deviation_m_lo", "mean_deviation_m_hi"})
    EXPECT_EQ(row[column], "") << column;
  EXPECT_EQ(cells(folder / "runs.csv", "elm,2,")["mean_deviation_m"], "");
  EXPECT_EQ(cells(folder / "table.csv", "none,")["mean_deviation_m"], "0.4");
  std::ostringstream out;
  print_tables(out, results, claims);
  EXPECT_THAT(out.str(), HasSubstr("FAILS    elm.mean_deviation_m <= 1   (- against 1"));
}

/// Every solve of a run may fail, the one before its first step too.
TEST(RaceTables, NoMoreThanAllSolvesFail) {
  const RaceSpec race = race_of("[]", 1);
  RaceResults results = {race, {run_of("elm", 1, 0, {8, 9})}, {"elm"}};
  results.runs[0].summary.solver_failures = results.runs[0].summary.steps + 1;
  std::ostringstream out;
  print_tables(out, results, {});
  EXPECT_THAT(out.str(), HasSubstr("finished, 100 % of solves failed"));
}

TEST(RaceTables, ThePrintedTableMarksWhoWasToldTheTruth) {
  const RaceSpec race = race_of(R"(["elm.violation_s <= none.violation_s", "none.violation_s < elm.violation_s",
                                    "elm.solve_ms_median < none.solve_ms_median"])");
  RaceResults results = {race, some_runs(), {"none", "elm", "oracle"}};
  results.runs[4].timing.alone = false;
  std::ostringstream out;
  print_tables(out, results, judge_all(results));
  EXPECT_THAT(out.str(), AllOf(HasSubstr("oracle *"), HasSubstr("* was told the truth"), Not(HasSubstr("elm *"))));
  EXPECT_THAT(out.str(), HasSubstr("2/3 finished"));
  EXPECT_THAT(out.str(), HasSubstr("1 skipped"));
  EXPECT_THAT(out.str(), HasSubstr("FAILS    none.violation_s < elm.violation_s   (4 against 2,"));
  EXPECT_THAT(out.str(), HasSubstr("skipped  elm.solve_ms_median < none.solve_ms_median   (on times: needs -j 1)"));
  EXPECT_THAT(out.str(), AllOf(HasSubstr("corner out: with a corner of the car"), HasSubstr("out, adapted: outside")));
}

TEST(RaceTables, BelowSixRunsTheEndsAreCalledARange) {
  const RaceSpec race = race_of(R"(["none.violation_s_hi <= 5", "none.violation_s_lo > 3"])");
  const RaceResults results = {race, some_runs(), {"none", "elm", "oracle"}};
  const std::vector<ClaimResult> claims = judge_all(results);
  EXPECT_TRUE(claims.at(0).holds.value());
  std::ostringstream out;
  print_tables(out, results, claims);
  EXPECT_THAT(out.str(), AllOf(HasSubstr("\n  range "), HasSubstr("range, of fewer than 6 runs: smallest and largest"),
                               Not(HasSubstr("bootstrap"))));
  EXPECT_THAT(out.str(), HasSubstr("warning: none.violation_s_hi <= 5: _lo and _hi are the smallest and largest of 3 "
                                   "runs, no 95 % interval"));
  EXPECT_THAT(out.str(), HasSubstr("FAILS    none.violation_s_lo > 3   (3 against 3; _lo and _hi are the smallest"));
  const Folder folder;
  write_claims(folder.path(), claims);
  EXPECT_THAT(contents(folder / "claims.json"), HasSubstr("smallest and largest of 3 runs"));
}

TEST(RaceTables, FromSixRunsTheEndsAreAnInterval) {
  const RaceSpec race = race_of(R"(["none.violation_s_hi <= 7"])", 6);
  std::vector<RunResult> runs;
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
    runs.push_back(
        run_of("none", seed, static_cast<double>(seed), seed < 3 ? std::vector<double>{8, 9} : std::vector<double>{8}));
  const RaceResults results = {race, runs, {"none"}};
  std::ostringstream out;
  print_tables(out, results, judge_all(results));
  EXPECT_THAT(out.str(), AllOf(HasSubstr("\n  95 %"), HasSubstr("9.00..9.00 of 2"), HasSubstr("bootstrap interval"),
                               Not(HasSubstr("no 95 %"))));
}

using RaceTablesInCommaLocale = InCommaLocale;

TEST_F(RaceTablesInCommaLocale, CellsHavePoints) {
  EXPECT_EQ(cell_text(1.5, "%.2f s"), "1.50 s");
  EXPECT_EQ(cell_text(std::nullopt, "%.2f s"), "-");
}

}  // namespace test_race_tables
}  // namespace gripline
