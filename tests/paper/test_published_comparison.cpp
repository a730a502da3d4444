// The figures that the README quotes against the published ones, raced anew: the paper's Table I with the real-time
// controller, the validation between two tracks, and `best` through a sudden loss of grip.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/paths.hpp"
#include "support/program.hpp"
#include "util/csv.hpp"

namespace gripline {
namespace test_published_comparison {

using namespace testing_support;

/// Runs an experiment of the repository into a folder; expects every claim to hold.
class Published : public testing::Test {
 protected:
  void compare(const std::string& experiment, std::vector<std::string> more) {
    std::vector<std::string> words = {"compare", source_dir() / ("experiments/" + experiment + ".json"), "--out",
                                      (folder_ / "out").string()};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = gripline_with(words);
    ASSERT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  }
  /// A row of one of the tables, by its first cells.
  std::map<std::string, std::string> row(const char* file, const std::vector<std::string>& key) const {
    const std::vector<std::string> all = lines(folder_ / (std::string("out/") + file));
    const std::vector<std::string> names = cells(all.at(0));
    for (const std::string& line : all) {
      const std::vector<std::string> values = cells(line);
      if (!std::equal(key.begin(), key.end(), values.begin())) continue;
      std::map<std::string, std::string> found;
      for (std::size_t i = 0; i < names.size(); ++i) found[names[i]] = values[i];
      return found;
    }
    ADD_FAILURE() << "no such row in " << file;
    return {};
  }
  static double number(const std::map<std::string, std::string>& row, const std::string& name) {
    return row.count(name) != 0 && !row.at(name).empty() ? std::stod(row.at(name)) : NAN;
  }

 private:
  static std::vector<std::string> cells(const std::string& line) {
    std::vector<std::string> out(1);
    for (const char c : line) {
      if (c == ',')
        out.emplace_back();
      else
        out.back() += c;
    }
    return out;
  }
  Folder folder_;
};

/// The adaptive row of the authors' code run again: laps 8.54 7.66 8.02 8.76 s, deviation 0.050 m, outside for 1.22 s.
/// Printed are 8.28 7.42 7.76 8.46 s, 0.0832 m and 0.46 s, which elm does not reach.
TEST_F(Published, TheAdaptiveRowOfTableOneIsNoWorse) {
  compare("table1", {"--only", "none,constant_speed,elm", "--set", "/base/controller/plugin=\"mpc_sqp\""});
  const auto elm = row("table.csv", {"elm"});
  EXPECT_LE(number(elm, "lap0_s"), 8.54);
  EXPECT_LE(number(elm, "lap1_s"), 7.66);
  EXPECT_LE(number(elm, "lap2_s"), 8.02);
  EXPECT_LE(number(elm, "lap3_s"), 8.76);
  EXPECT_LE(number(elm, "mean_deviation_m"), 0.050);
  EXPECT_LE(number(elm, "violation_s"), 1.22);
  EXPECT_LE(number(elm, "mu_visited_rmse"), 0.03);
  EXPECT_EQ(number(elm, "solver_failures"), 0);
}

TEST_F(Published, WhatIsLearnedOnOneTrackHoldsOnAnother) {
  compare("offline_validation", {});
  for (const char* channel : {"e_vx", "e_vy", "e_omega"}) {
    const double elm = number(row("validation.csv", {"elm", channel}), "r2");
    EXPECT_GE(elm, 0.95) << channel;
    EXPECT_GE(elm, number(row("validation.csv", {"gp", channel}), "r2") - 0.02) << channel;
  }
}

/// LLA-MPC by its authors' raw data: laps 7.74 7.76 9.16 s and 0.65 s outside, privileged. The claims state the pace.
TEST_F(Published, TheBestRowPassesASuddenLossOfGripInside) {
  compare("ethz_exp2_sudden", {"--only", "best,best_body"});
  const auto best = row("table.csv", {"best"});
  EXPECT_EQ(number(best, "needs_truth"), 0);
  EXPECT_LE(number(best, "violation_s"), 0.10);
  EXPECT_LE(number(best, "mu_rmse"), 0.03);
  EXPECT_LT(number(best, "lap2_s"), 9.16);
  // A car that stays inside is no faster than the limit, whose error is below 0.1 %. Lap 2 begins with speed from
  // before the drop, as a flying lap at its friction does not: worth up to 0.03 s of 7.84 s from other starts
  // (results.md).
  for (const char* ratio : {"pace_ratio1", "pace_ratio3"}) EXPECT_GE(number(best, ratio), 0.999) << ratio;
  EXPECT_GE(number(best, "pace_ratio2"), 0.995);
  // The drop comes when the car is about to enter a slow turn, in which a corner leaves the road.
  const auto body = row("table.csv", {"best_body"});
  EXPECT_EQ(number(body, "violation_s"), 0);
  EXPECT_LE(number(body, "violation_body_s"), 0.2);
  for (const char* ratio : {"body_pace_ratio1", "body_pace_ratio2", "body_pace_ratio3"}) {
    EXPECT_GE(number(body, ratio), 0.999) << ratio;
    EXPECT_LE(number(body, ratio), std::string(ratio) == "body_pace_ratio1" ? 1.06 : 1.05) << ratio;
  }
}

/// With slips up to 0.7 rad a plan can slide round a turn backwards, which the planner's equations allow. A first lap
/// that is solved in windows of nearly the whole lap has such a part, windows as long keep it, and laps take 9 to 15 s.
TEST_F(Published, TheBestRowToldATooHeavyCarDrivesAsFast) {
  compare("sensitivity_1_43",
          {"--only", "mass_more", "--set", "/seeds/count=1", "--set", "/stacks/mass_more/planner/params/slip_max=0.7"});
  const auto told = row("table.csv", {"mass_more"});
  EXPECT_EQ(number(told, "violation_s"), 0);
  EXPECT_LE(number(told, "lap1_s"), 7.2);
}

/// From this start, told this car, a window settles in a plan that all but stops in a hairpin, and would keep it: laps
/// of 7.7, 8.2 and 13.2 s.
TEST_F(Published, TheBestRowLeavesAPlanThatNearlyStops) {
  compare("sensitivity_1_43", {"--only", "all_1", "--set", "/seeds/first=650882455", "--set", "/seeds/count=1"});
  const auto told = row("table.csv", {"all_1"});
  EXPECT_EQ(number(told, "violation_s"), 0);
  for (const char* lap : {"lap1_s", "lap2_s", "lap3_s"}) EXPECT_LE(number(told, lap), 7.6) << lap;
}

}  // namespace test_published_comparison
}  // namespace gripline
