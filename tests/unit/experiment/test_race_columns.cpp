#include "experiment/race_columns.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace gripline {
namespace test_race_columns {

using testing::Contains;
using testing::ElementsAre;
using testing::Not;

RunResult two_laps() {
  RunResult run;
  run.summary.status = Status::finished;
  run.summary.laps = {9.0, 8.0};
  run.summary.lap_mean_factors = {1.0, 0.75};
  run.summary.violation_s = 0.25;
  run.summary.steps = 850;
  run.summary.simulated_s = 17.0;
  run.timing.cpu_s = 3.0;
  return run;
}

std::optional<double> read(const std::string& name, const RunResult& run, const WorldSpec& world = {}) {
  const std::optional<NamedColumn> named = find_race_column(name);
  if (!named) {
    ADD_FAILURE() << name;
    return std::nullopt;
  }
  return named->column->read(world, run, named->lap);
}

TEST(RaceColumns, AreReadFromARun) {
  const RunResult run = two_laps();
  EXPECT_EQ(read("lap1_s", run), 8.0);
  EXPECT_EQ(read("lap1_mean_factor", run), 0.75);
  EXPECT_EQ(read("violation_s", run), 0.25);
  EXPECT_EQ(read("violation_s_max", run), 0.25);
  EXPECT_EQ(read("cpu_s", run), 3.0);
  EXPECT_EQ(read("finished", run), 1.0);
  EXPECT_EQ(read("crashed", run), 0.0);
}

TEST(RaceColumns, WhatWasNotMeasuredIsEmpty) {
  const RunResult run = two_laps();
  EXPECT_EQ(read("lap2_s", run), std::nullopt);
  EXPECT_EQ(read("mean_deviation_m", run), std::nullopt) << "the planner followed no line";
  EXPECT_EQ(read("mu_rmse", run), std::nullopt) << "the stack never trusted its belief";
  EXPECT_EQ(read("pace_ratio1", run), std::nullopt) << "the world states no limit";
  RunResult lost;
  EXPECT_EQ(read("violation_s", lost), std::nullopt) << "a run that was lost measured nothing";
  EXPECT_EQ(read("runs", lost), 1.0);
}

TEST(RaceColumns, ARunThatWasNotDrivenAgainCostNothing) {
  RunResult run = two_laps();
  run.driven_as = 1;
  EXPECT_EQ(read("cpu_s", run), 0.0);
  EXPECT_EQ(read("simulated_s", run), 0.0);
  EXPECT_EQ(read("seeds", run), 0.0);
  EXPECT_EQ(read("lap0_s", run), 9.0);
}

TEST(RaceColumns, PaceIsAgainstTheLimitAtTheLapsOwnFriction) {
  WorldSpec world;
  world.time_optimal.laps = {{0.5, 10.0}, {1.0, 5.0}};
  EXPECT_NEAR(read("pace_ratio1", two_laps(), world).value(), 8.0 / 7.5, 1e-15);
  EXPECT_EQ(read("body_pace_ratio1", two_laps(), world), std::nullopt) << "no limit for the whole car is stated";
}

TEST(RaceColumns, PaceWithTheWholeCarInsideHasALimitOfItsOwn) {
  WorldSpec world;
  world.time_optimal.laps = {{0.5, 10.0}, {1.0, 5.0}};
  world.time_optimal_body.laps = {{0.5, 11.0}, {0.8, 8.0}};
  EXPECT_NEAR(read("body_pace_ratio1", two_laps(), world).value(), 8.0 / 8.5, 1e-15);
  EXPECT_EQ(read("body_pace_ratio0", two_laps(), world), std::nullopt) << "its factor is beyond the table";
  EXPECT_NEAR(read("pace_ratio0", two_laps(), world).value(), 9.0 / 5.0, 1e-15);
}

TEST(RaceColumns, NamesCarryTheLap) {
  EXPECT_EQ(find_race_column("lap12_s")->lap, 12u);
  EXPECT_STREQ(find_race_column("lap12_s")->column->name, "lapK_s");
  for (const char* wrong : {"lap_s", "lapK_s", "lap1", "lap1x_s", "pace_ratio", "body_pace_ratio", "", "violation"})
    EXPECT_FALSE(find_race_column(wrong).has_value()) << wrong;
}

TEST(RaceColumns, HeadersNameEachLapAndNothingTwice) {
  const std::vector<std::string> names = race_column_names("table.csv", 2);
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
  EXPECT_THAT(std::vector<std::string>(names.begin(), names.begin() + 4),
              ElementsAre("lap0_s", "lap1_s", "lap0_mean_factor", "lap1_mean_factor"));
  EXPECT_THAT(names, Contains("pace_ratio1"));
  EXPECT_THAT(race_column_names("runs.csv", 2), Not(Contains("pace_ratio1")));
  for (const std::string& name : names) EXPECT_TRUE(find_race_column(name).has_value()) << name;
}

TEST(RaceColumns, SweepsRecordWhatComesOutTheSameEachTime) {
  EXPECT_THAT(recorded_columns(2),
              ElementsAre("finished", "lap0_s", "pace_ratio0", "body_pace_ratio0", "lap1_s", "pace_ratio1",
                          "body_pace_ratio1", "mean_deviation_m", "violation_s", "violation_body_s",
                          "violation_after_adapt_s", "violation_body_after_adapt_s", "mu_rmse", "mu_visited_rmse",
                          "solver_failures", "steps", "simulated_s"));
}

/// Sums, counts, maxima and what is known beforehand have no interval.
TEST(RaceColumns, ClaimsMayNameEndsOfIntervals) {
  for (const char* name : {"lap1_s_lo", "mu_rmse_hi", "pace_ratio0_hi", "body_pace_ratio2_hi", "hilly_deviation_m",
                           "hilly_deviation_m_lo"})
    EXPECT_TRUE(is_table_column(name)) << name;
  for (const char* name : {"runs_lo", "cpu_s_hi", "violation_s_max_lo", "lap1_mean_factor_lo", "lap1_s_lo_lo", "_lo"})
    EXPECT_FALSE(is_table_column(name)) << name;
}

}  // namespace test_race_columns
}  // namespace gripline
