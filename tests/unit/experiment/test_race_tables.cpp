#include "experiment/race_tables.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "experiment/race_judging.hpp"
#include "experiment/race_printing.hpp"
#include "support/race_sample.hpp"

namespace gripline {
namespace test_race_tables {

using testing::HasSubstr;
using namespace testing_support;

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

}  // namespace test_race_tables
}  // namespace gripline
