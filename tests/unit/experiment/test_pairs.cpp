#include "experiment/pairs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string_view>

#include "support/host_support.hpp"

namespace gripline {
namespace test_pairs {

using testing::HasSubstr;
using testing::Not;
using namespace testing_support;

RaceSpec race_of() {
  Node world = merge(small_world(), json(R"({"duration": null, "laps": 1, "timeout": 9})"));
  inline_world_files(world);
  Node tree = json(R"({"base": {"model": {"plugin": "ekinematic"}, "planner": {"plugin": "fixed_speed"},
    "controller": {"plugin": "pure_pursuit"}}, "stacks": {"none": {}, "elm": {}}})");
  tree.set("world", world);
  tree.set("seeds", json(R"({"count": 6})"));
  return read_race("pairs.json", tree, plugins());
}

RunResult run_of(const std::string& stack, std::uint64_t seed, double violation, std::vector<double> laps,
                 const std::string& drive = "") {
  RunResult run;
  run.summary.stack = stack;
  run.summary.seed = seed;
  run.summary.status = Status::finished;
  run.summary.lap_mean_factors.assign(laps.size(), 1.0);
  run.summary.laps = std::move(laps);
  run.summary.violation_s = violation;
  run.summary.steps = 100;
  run.drive = drive;
  return run;
}

const PairedDifference& find(const std::vector<PairedDifference>& pairs, std::string_view column) {
  for (const PairedDifference& pair : pairs)
    if (pair.column == column) return pair;
  throw std::runtime_error("no " + std::string(column));
}

/// The rows vary by whole seconds from draw to draw, their difference by hundredths.
std::vector<RunResult> six_pairs() {
  std::vector<RunResult> runs;
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
    runs.push_back(run_of("none", seed, 3.0 + static_cast<double>(seed), {20.0 + static_cast<double>(seed)}));
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const auto s = static_cast<double>(seed);
    runs.push_back(run_of("elm", seed, 3.0 + s - 0.5 - 0.01 * s, {20.0 + s}));
  }
  return runs;
}

TEST(Pairs, AreOfTheSameDraw) {
  const RaceSpec race = race_of();
  const auto pairs = paired_differences({race, six_pairs(), {"none", "elm"}}, "none");
  const PairedDifference& outside = find(pairs, "violation_s");
  EXPECT_EQ(outside.stack, "elm");
  EXPECT_EQ(outside.draws, 6);
  EXPECT_NEAR(outside.difference.value(), -0.535, 1e-9);
  EXPECT_GE(outside.lo.value(), -0.5601);
  EXPECT_LE(outside.hi.value(), -0.5099);
  EXPECT_DOUBLE_EQ(outside.p, 2.0 / 64.0);
  EXPECT_DOUBLE_EQ(find(pairs, "lap0_s").difference.value(), 0);
  EXPECT_DOUBLE_EQ(find(pairs, "lap0_s").p, 1);
}

/// Of these runs none followed a line.
TEST(Pairs, AColumnThatNoRunMeasuredHasEmptyCells) {
  const Folder folder;
  const RaceSpec race = race_of();
  std::vector<RunResult> runs = six_pairs();
  for (std::size_t i = 0; i < 6; ++i) runs[i].summary.mean_deviation_m = 0.1;  // of the baseline alone
  const auto pairs = paired_differences({race, runs, {"none", "elm"}}, "none");
  EXPECT_EQ(find(pairs, "mean_deviation_m").draws, 0);
  EXPECT_FALSE(find(pairs, "mean_deviation_m").difference.has_value());
  write_pairs(folder.path(), "none", pairs);
  EXPECT_THAT(contents(folder / "pairs.csv"), HasSubstr("elm,none,mean_deviation_m,,,,,0\n"));
  std::ostringstream out;
  print_pairs(out, "none", pairs);
  EXPECT_THAT(out.str(), Not(HasSubstr("mean_deviation_m")));
}

TEST(Pairs, ADrawThatOneRowDidNotMeasureIsLeftOut) {
  const RaceSpec race = race_of();
  std::vector<RunResult> runs = six_pairs();
  runs[2].summary.laps.clear();
  runs.erase(runs.begin() + 6);  // elm lost its first seed
  const auto pairs = paired_differences({race, runs, {"none", "elm"}}, "none");
  EXPECT_EQ(find(pairs, "lap0_s").draws, 4);
  EXPECT_EQ(find(pairs, "violation_s").draws, 5);
}

TEST(Pairs, EqualToTheLastBitCountOnce) {
  const RaceSpec race = race_of();
  std::vector<RunResult> runs;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) runs.push_back(run_of("none", seed, 2, {8}, "same"));
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
    runs.push_back(run_of("elm", seed, seed < 3 ? 1 : 1.5, {7}, seed < 3 ? "a" : "b"));
  const auto pairs = paired_differences({race, runs, {"none", "elm"}}, "none");
  EXPECT_EQ(find(pairs, "violation_s").draws, 2);
  EXPECT_DOUBLE_EQ(find(pairs, "violation_s").difference.value(), -0.75);
}

TEST(Pairs, AreWrittenAndPrinted) {
  const RaceSpec race = race_of();
  const Folder folder;
  const auto pairs = paired_differences({race, six_pairs(), {"none", "elm"}}, "none");
  write_pairs(folder.path(), "none", pairs);
  const std::vector<std::string> all = lines(folder / "pairs.csv");
  EXPECT_EQ(all.at(0), "stack,baseline,column,difference,lo,hi,p,draws");
  EXPECT_THAT(all, testing::Contains(testing::StartsWith("elm,none,violation_s,-0.53")));
  EXPECT_THAT(all, testing::Contains("elm,none,mu_rmse,,,,,0"));
  std::ostringstream out;
  print_pairs(out, "none", pairs);
  EXPECT_THAT(out.str(), HasSubstr("minus none"));
  EXPECT_THAT(out.str(), HasSubstr("violation_s  -0.535  -0.555 to -0.515  0.031    0.031      6"));
  EXPECT_THAT(out.str(),
              testing::AllOf(HasSubstr("  95 %  "), HasSubstr("bootstrap interval"), Not(HasSubstr("range"))));
  EXPECT_THAT(out.str(), Not(HasSubstr("mu_rmse")));  // nobody measured it
}

TEST(Pairs, OfFewDrawsHaveARangeAndALeastP) {
  const RaceSpec race = race_of();
  std::vector<RunResult> runs = six_pairs();
  std::erase_if(runs, [](const RunResult& run) { return run.summary.seed > 2; });
  std::ostringstream out;
  print_pairs(out, "none", paired_differences({race, runs, {"none", "elm"}}, "none"));
  EXPECT_THAT(out.str(), testing::AllOf(HasSubstr("  range  "), HasSubstr("smallest and largest difference"),
                                        Not(HasSubstr("95 %")), Not(HasSubstr("bootstrap"))));
  EXPECT_THAT(out.str(), HasSubstr("violation_s  -0.515  -0.520 to -0.510  0.5      0.5      2"));
}

TEST(Pairs, OfRowsWithFewAndWithManyDrawsSaysBoth) {
  const RaceSpec race = race_of();
  std::vector<RunResult> runs = six_pairs();
  runs[2].summary.laps.clear();
  std::ostringstream out;
  print_pairs(out, "none", paired_differences({race, runs, {"none", "elm"}}, "none"));
  EXPECT_THAT(out.str(), testing::AllOf(HasSubstr("95 % or range"), HasSubstr("bootstrap interval"),
                                        HasSubstr("range, of fewer than 6 draws")));
}

}  // namespace test_pairs
}  // namespace gripline
