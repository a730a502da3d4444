#include "experiment/race_printing.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "experiment/race_judging.hpp"
#include "experiment/race_tables.hpp"
#include "support/race_sample.hpp"

namespace gripline {
namespace test_race_printing {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using namespace testing_support;

/// Every solve of a run may fail, the one before its first step too.
TEST(RacePrinting, NoMoreThanAllSolvesFail) {
  const RaceSpec race = race_of("[]", 1);
  RaceResults results = {race, {run_of("elm", 1, 0, {8, 9})}, {"elm"}};
  results.runs[0].summary.solver_failures = results.runs[0].summary.steps + 1;
  std::ostringstream out;
  print_tables(out, results, {});
  EXPECT_THAT(out.str(), HasSubstr("finished, 100 % of solves failed"));
}

TEST(RacePrinting, ThePrintedTableMarksWhoWasToldTheTruth) {
  const RaceSpec race = race_of(R"(["elm.violation_s <= none.violation_s", "none.violation_s < elm.violation_s",
                                    "elm.solve_ms_median < none.solve_ms_median"])");
  RaceResults results = {race, some_runs(), {"none", "elm", "oracle"}};
  results.runs[4].timing.alone = false;
  std::ostringstream out;
  print_tables(out, results, judge_all(results));
  EXPECT_THAT(out.str(),
              AllOf(HasSubstr("oracle *"), HasSubstr("* is given the ground truth"), Not(HasSubstr("elm *"))));
  EXPECT_THAT(out.str(), HasSubstr("2/3 finished"));
  EXPECT_THAT(out.str(), HasSubstr("1 skipped"));
  EXPECT_THAT(out.str(), HasSubstr("FAILS    none.violation_s < elm.violation_s   (4 against 2,"));
  EXPECT_THAT(out.str(), HasSubstr("skipped  elm.solve_ms_median < none.solve_ms_median   (on times: needs -j 1)"));
  EXPECT_THAT(out.str(), AllOf(HasSubstr("corner out: with a corner of the car"), HasSubstr("out, adapted: outside")));
}

/// Medians that would hold do not read as if the claim did.
TEST(RacePrinting, AClaimThatSingleRunsRefuteSaysSo) {
  const RaceSpec race = race_of(R"(["elm.violation_s <= 2.5"])");
  const RaceResults results = {
      race, {run_of("elm", 1, 1, {8}), run_of("elm", 2, 2, {8}), run_of("elm", 3, 3, {8})}, {"elm"}};
  std::ostringstream out;
  print_tables(out, results, judge_all(results));
  EXPECT_THAT(out.str(),
              HasSubstr("FAILS    elm.violation_s <= 2.5   (2 against 2.5 at the median, but holds in 2 of 3 "
                        "runs, 80 % wanted)"));
}

TEST(RacePrinting, BelowSixRunsTheEndsAreCalledARange) {
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

TEST(RacePrinting, FromSixRunsTheEndsAreAnInterval) {
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

/// What is said below the table of a row whose runs were outside for so long [s], a corner in the first for more.
std::string said_of(const std::vector<double>& outside, double corners_more = 0.0) {
  const RaceSpec race = race_of("[]", static_cast<int>(outside.size()));
  std::vector<RunResult> runs;
  for (std::size_t i = 0; i < outside.size(); ++i) {
    runs.push_back(run_of("elm", i + 1, outside[i], {8, 9}));
    runs.back().summary.violation_body_s = outside[i] + (i == 0 ? corners_more : 0.0);
  }
  std::ostringstream out;
  print_tables(out, {race, runs, {"elm"}}, {});
  std::string said;
  std::istringstream lines(out.str());
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("elm: ")) said += line;
  return said;
}

/// A median of 0.00 s must not hide the runs that left the road.
TEST(RacePrinting, RunsOutsideThatTheMedianHidesAreTold) {
  EXPECT_EQ(said_of({0, 0, 0.5, 0, 2.64, 0, 0}),
            "elm: the centre of gravity left the road in 2 of 7 runs, for 2.64 s in the worst (seed 5); "
            "a corner of the car left the road in 2 of 7 runs, for 2.64 s in the worst (seed 5)");
  EXPECT_EQ(said_of({0, 0, 0, 0, 0, 0}, 0.3),
            "elm: a corner of the car left the road in 1 of 6 runs, for 0.30 s in the worst (seed 1)");
  EXPECT_EQ(said_of({0, 0, 0, 0, 0, 0}), "");
  EXPECT_EQ(said_of({1, 2, 3, 4, 5, 6}), "");  // the median says it
  EXPECT_EQ(said_of({0, 0, 1}), "");           // the range says it
}

}  // namespace test_race_printing
}  // namespace gripline
