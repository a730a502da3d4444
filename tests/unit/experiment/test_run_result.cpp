#include "experiment/run_result.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/hash.hpp"
#include "config/json_file.hpp"
#include "support/host_support.hpp"
#include "util/csv_writer.hpp"

namespace gripline {
namespace test_run_result {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using namespace testing_support;
namespace fs = std::filesystem;

RunSummary some() {
  RunSummary s;
  s.stack = "elm";
  s.seed = 7;
  s.status = Status::finished;
  s.needs_truth = true;
  s.laps = {8.5, 7.25};
  s.lap_mean_factors = {1, 0.9};
  s.mean_deviation_m = 0.05;
  s.violation_s = 0.46;
  s.violation_body_s = 1.5;
  s.violation_after_adapt_s = 0.2;
  s.violation_body_after_adapt_s = 0.7;
  s.mu_rmse = 0.02;
  s.mu_bias = -0.01;
  s.plan_latency_s = 4.3;
  s.solver_failures = 3;
  s.steps = 1780;
  s.simulated_s = 35.6;
  return s;
}

void write_times(const Folder& folder) {
  write_text(folder / "timing.csv", "t_s,update_ms,plan_ms,solve_ms,cpu_s\n0,1,1,1,1\n");
}

TEST(RunResult, ASummaryComesBack) {
  const Folder folder;
  write_times(folder);
  write_summary(folder.path(), some(), "key");
  const RunSummary s = read_result(folder.path(), "key").value().summary;
  EXPECT_EQ(s.stack, "elm");
  EXPECT_EQ(s.seed, 7u);
  EXPECT_EQ(s.status, Status::finished);
  EXPECT_TRUE(s.needs_truth);
  EXPECT_THAT(s.laps, ElementsAre(8.5, 7.25));
  EXPECT_THAT(s.lap_mean_factors, ElementsAre(1, 0.9));
  EXPECT_EQ(s.mean_deviation_m, 0.05);
  EXPECT_EQ(s.violation_s, 0.46);
  EXPECT_EQ(s.violation_body_s, 1.5);
  EXPECT_EQ(s.violation_after_adapt_s, 0.2);
  EXPECT_EQ(s.violation_body_after_adapt_s, 0.7);
  EXPECT_EQ(s.mu_rmse, 0.02);
  EXPECT_EQ(s.mu_bias, -0.01);
  EXPECT_FALSE(s.mu_visited_rmse.has_value());  // null: was not measured
  EXPECT_EQ(s.plan_latency_s, 4.3);
  EXPECT_EQ(s.solver_failures, 3);
  EXPECT_EQ(s.steps, 1780);
  EXPECT_EQ(s.simulated_s, 35.6);
  EXPECT_THAT(contents(folder / "summary.json"), HasSubstr("\"mu_visited_rmse\": null"));
}

TEST(RunResult, EveryStatusComesBackWithItsMessage) {
  for (const Status status :
       {Status::finished, Status::crashed, Status::timeout, Status::plugin_error, Status::error}) {
    const Folder folder;
    write_times(folder);
    RunSummary s = some();
    s.status = status;
    s.message = "why, with \"quotes\"\nand a line";
    write_summary(folder.path(), s, "key");
    EXPECT_EQ(read_result(folder.path(), "").value().summary.status, status);
    EXPECT_EQ(read_result(folder.path(), "").value().summary.message, s.message);
  }
}

TEST(RunResult, AnotherKeyIsNotThisRun) {
  const Folder folder;
  write_times(folder);
  write_summary(folder.path(), some(), "key");
  EXPECT_FALSE(read_result(folder.path(), "other").has_value());
  EXPECT_TRUE(read_result(folder.path(), "").has_value());
  EXPECT_FALSE(read_result(folder / "absent", "").has_value());
}

TEST(RunResult, WhatIsNotWholeIsAsIfAbsent) {
  const Folder folder;
  write_text(folder / "summary.json", R"({"stack": "elm", "sta)");
  EXPECT_FALSE(read_result(folder.path(), "").has_value());
  write_summary(folder.path(), some(), "key");
  write_text(folder / "timing.csv", "t_s,update_ms\n0,1,2\n");
  EXPECT_FALSE(read_result(folder.path(), "").has_value());
}

/// A result that is not the one that was written is not believed, and what is wrong with it is told.
TEST(RunResult, WhatWasChangedIsFound) {
  const Folder folder;
  const auto damage = [&] {
    std::string found = "none";
    const bool believed = read_result(folder.path(), "key", &found).has_value();
    EXPECT_EQ(believed, found.empty());
    return found;
  };
  const auto write_all = [&] {
    write_text(folder / "steps.csv", "t_s,x_m\n0,1\n0.02,2\n");
    write_times(folder);
    write_text(folder / "log.txt", "words");
    write_summary(folder.path(), some(), "key");
  };
  write_all();
  EXPECT_EQ(damage(), "");
  write_text(folder / "log.txt", "more words");  // of a plugin that is destroyed
  EXPECT_EQ(damage(), "");
  EXPECT_THAT(contents(folder / "timing.sha256"),
              EndsWith("\n" + sha256_of_file(folder / "timing.csv") + "  timing.csv\n"));
  fs::resize_file(folder / "steps.csv", 10);
  EXPECT_EQ(damage(), "steps.csv was changed or cut");
  fs::remove(folder / "steps.csv");
  EXPECT_EQ(damage(), "steps.csv is missing or cannot be read");
  write_all();
  write_text(folder / "timing.csv", "t_s,update_ms,plan_ms,solve_ms,cpu_s\n0,1,1,0,1\n");
  EXPECT_EQ(damage(), "timing.csv was changed or cut");
  write_all();
  fs::remove(folder / "timing.csv");
  EXPECT_EQ(damage(), "timing.csv was changed or cut");
  fs::remove(folder / "timing.sha256");
  EXPECT_EQ(damage(), "timing.csv is missing");
  write_all();
  fs::remove(folder / "timing.sha256");
  EXPECT_EQ(damage(), "timing.csv was changed or cut");
  write_all();
  std::string summary = contents(folder / "summary.json");
  summary.replace(summary.find("0.46"), 4, "0.00");
  write_text(folder / "summary.json", summary);
  EXPECT_EQ(damage(), "summary.json was changed");
  std::string other;
  EXPECT_FALSE(read_result(folder.path(), "another key", &other).has_value());
  EXPECT_EQ(other, "");  // another run's, and none of our business
}

/// A time outside of 0 is the best that a run can have: a summary without one is none, even with a hash that fits.
TEST(RunResult, ASummaryWithoutItsNumbersIsDamaged) {
  const Folder folder;
  write_times(folder);
  write_summary(folder.path(), some(), "key");
  const Node whole = parse_file(folder / "summary.json");
  const auto damage = [&](Node summary) {
    summary.erase("sha256");
    summary.set("sha256", Node(sha256_hex(content_text(summary))));
    write_text(folder / "summary.json", to_json_text(summary));
    std::string found = "none";
    const bool read = read_result(folder.path(), "key", &found).has_value();
    EXPECT_EQ(read, found.empty());
    return found;
  };
  EXPECT_EQ(damage(whole), "");
  for (const char* number :
       {"seed", "violation_s", "violation_body_s", "plan_latency_s", "solver_failures", "steps", "simulated_s"}) {
    Node without = whole, null = whole;
    without.erase(number);
    null.set(number, Node());
    EXPECT_EQ(damage(without), std::string(number) + " in summary.json is missing");
    EXPECT_EQ(damage(null), std::string(number) + " in summary.json is missing");
  }
}

/// A process that was lost may have left none, and its row has no times then.
TEST(RunResult, OnlyARunWithoutAStepMayHaveNoTimes) {
  const Folder folder;
  RunSummary s = some();
  s.status = Status::error;
  s.steps = 0;
  write_summary(folder.path(), s, "key");
  std::string damage;
  EXPECT_TRUE(read_result(folder.path(), "key", &damage).has_value());
  EXPECT_EQ(damage, "");
  s.steps = 1;
  write_summary(folder.path(), s, "key");
  EXPECT_FALSE(read_result(folder.path(), "key", &damage).has_value());
  EXPECT_EQ(damage, "timing.csv is missing");
}

/// A run that was not driven again has the times of the one that it equals.
TEST(RunResult, ACopyHasTheTimesOfTheRunThatWasDriven) {
  const Folder out;
  const fs::path driven = out / "elm/7", copy = out / "elm/9";
  for (const fs::path& folder : {driven, copy}) fs::create_directories(folder);
  write_text(driven / "timing.csv", "t_s,update_ms,plan_ms,solve_ms,cpu_s\n0,1,1,3,1\n");
  write_summary(driven, some(), "key", true);
  write_copied_summary(copy, read_result(driven, "key").value(), 9, "key");
  const RunTiming timing = read_result(copy, "key").value().timing;
  EXPECT_EQ(timing.solve_ms_median, 3);
  EXPECT_TRUE(timing.alone);
  for (const char* name : {"timing.csv", "timing.sha256"}) fs::remove(driven / name);
  std::string damage;
  EXPECT_FALSE(read_result(copy, "key", &damage).has_value());
  EXPECT_EQ(damage, "timing.csv of seed 7 is missing");
}

TEST(RunResult, WhetherItWasAloneComesBack) {
  const Folder folder;
  write_times(folder);
  const auto alone = [&] { return read_result(folder.path(), "key").value().timing.alone; };
  write_summary(folder.path(), some(), "key", true);
  const std::string summary = contents(folder / "summary.json");
  EXPECT_TRUE(alone());
  write_summary(folder.path(), some(), "key", false);
  EXPECT_FALSE(alone());
  EXPECT_EQ(contents(folder / "summary.json"), summary) << "the same run, however many are driven at a time";
}

/// As programs wrote it that did not say whether a run was alone: the run counts, and its times may be others'.
TEST(RunResult, TimesOfWhichItIsNotKnownAreNotOfARunAlone) {
  const Folder folder;
  write_times(folder);
  write_summary(folder.path(), some(), "key", true);
  write_text(folder / "timing.sha256", sha256_of_file(folder / "timing.csv") + "  timing.csv\n");
  EXPECT_FALSE(read_result(folder.path(), "key").value().timing.alone);
  write_text(folder / "timing.sha256", "# alone\n" + sha256_of_file(folder / "timing.csv") + "  timing.csv\n");
  EXPECT_FALSE(read_result(folder.path(), "key").has_value()) << "nobody wrote that";
}

TEST(RunResult, WhatWasNotMeasuredStaysEmpty) {
  const Folder folder;
  write_times(folder);
  RunSummary s = some();
  s.mean_deviation_m.reset();
  write_summary(folder.path(), s, "key");
  EXPECT_FALSE(read_result(folder.path(), "key").value().summary.mean_deviation_m.has_value());
  EXPECT_THAT(contents(folder / "summary.json"), HasSubstr("\"mean_deviation_m\": null"));
}

TEST(RunResult, TimesAreNearestRankPercentiles) {
  const Folder folder;
  {
    CsvWriter csv(folder / "timing.csv", "t_s,update_ms,plan_ms,solve_ms,cpu_s");
    for (int i = 1; i <= 200; ++i) {
      csv << 0.02 * i << 2.0 * i << 0.0 << 201.0 - i << 0.1 * i;
      csv.end_row();
    }
  }
  write_summary(folder.path(), some(), "key");
  const RunTiming timing = read_result(folder.path(), "key").value().timing;
  EXPECT_EQ(timing.solve_ms_median, 100);
  EXPECT_EQ(timing.solve_ms_p95, 190);
  EXPECT_EQ(timing.solve_ms_p99, 198);
  EXPECT_EQ(timing.update_ms_median, 200);
  EXPECT_DOUBLE_EQ(timing.cpu_s, 20);
}

TEST(RunResult, WallClockFiguresAreNotInTheSummary) {
  const Folder folder;
  write_summary(folder.path(), some(), "key");
  EXPECT_THAT(contents(folder / "summary.json"), Not(testing::AnyOf(HasSubstr("_ms"), HasSubstr("cpu"))));
}

}  // namespace test_run_result
}  // namespace gripline
