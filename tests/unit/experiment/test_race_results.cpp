#include "experiment/race_results.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "experiment/race_judging.hpp"
#include "experiment/race_printing.hpp"
#include "experiment/race_tables.hpp"
#include "support/race_sample.hpp"

namespace gripline {
namespace test_race_results {

using testing::HasSubstr;
using testing::Not;
using namespace testing_support;

TEST(RaceResults, RunsEqualToTheLastBitCountOnce) {
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
TEST(RaceResults, RunsThatWereSparedCostNothing) {
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

TEST(RaceResults, FailedSolvesAreASum) {
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

}  // namespace test_race_results
}  // namespace gripline
