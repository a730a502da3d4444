#include "experiment/claims.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "support/host_support.hpp"

namespace gripline {
namespace test_claims {

using testing::HasSubstr;
using testing::StartsWith;
using namespace testing_support;

const std::vector<std::string> stacks = {"none", "elm", "gp", "n-20", "2fast", "infinite", "w0.3", "v1.a"};

Claim claim_of(const std::string& text) {
  Errors errors;
  const std::optional<Claim> claim = read_claim(Node(text), stacks, errors);
  errors.throw_if_any();
  return claim.value();
}
std::string why(const std::string& text) {
  return refusal([&] { claim_of(text); });
}

/// Judges with values by "stack.column"; the i-th is run i's, the median over them is given apart.
struct Values {
  std::map<std::string, std::vector<double>> runs;
  std::map<std::string, double> medians;
  std::optional<double> operator()(const std::string& stack, const std::string& column, int run) const {
    const std::string key = stack + "." + column;
    if (run < 0) return medians.count(key) > 0 ? std::optional(medians.at(key)) : std::nullopt;
    if (runs.count(key) == 0 || static_cast<std::size_t>(run) >= runs.at(key).size()) return std::nullopt;
    return runs.at(key)[static_cast<std::size_t>(run)];
  }
};
Values constant(double elm, double none) {
  return {{{"elm.violation_s", {elm}}, {"none.violation_s", {none}}},
          {{"elm.violation_s", elm}, {"none.violation_s", none}}};
}
bool holds(const std::string& text, const Values& values) {
  return judge(claim_of(text), 1, 0.8, values).holds.value();
}

TEST(Claims, CompareTwoColumns) {
  for (const auto& [left, right] : {std::pair{1.0, 2.0}, {2.0, 2.0}, {3.0, 2.0}}) {
    const Values values = constant(left, right);
    EXPECT_EQ(holds("elm.violation_s <= none.violation_s", values), left <= right);
    EXPECT_EQ(holds("elm.violation_s < none.violation_s", values), left < right);
    EXPECT_EQ(holds("elm.violation_s >= none.violation_s", values), left >= right);
    EXPECT_EQ(holds("elm.violation_s > none.violation_s", values), left > right);
    EXPECT_EQ(holds("elm.violation_s == none.violation_s", values), left == right);
  }
}

TEST(Claims, SpeakOfEndsOfIntervals) {
  const Values values = {{}, {{"elm.lap1_s_hi", 7.5}, {"none.lap1_s_lo", 8}}};
  EXPECT_TRUE(holds("elm.lap1_s_hi < none.lap1_s_lo", values));
  EXPECT_FALSE(holds("elm.lap1_s_hi < 7", values));
  EXPECT_FALSE(holds("elm.lap1_s_lo < 9", values));  // was not measured
  EXPECT_TRUE(claim_of("elm.lap1_s_hi < 7").about_interval());
  EXPECT_THAT(why("elm.violation_s_max_hi < 7"), HasSubstr("no column \"violation_s_max_hi\""));
  EXPECT_THAT(why("elm.runs_lo < 7"), HasSubstr("no column \"runs_lo\""));
}

TEST(Claims, TermsHaveFactorsAndOffsets) {
  const Values values = constant(1.0, 2.0);
  EXPECT_TRUE(holds("elm.violation_s == 0.5 * none.violation_s", values));
  EXPECT_TRUE(holds("2*elm.violation_s - 0.5 == none.violation_s-0.5", values));
  EXPECT_TRUE(holds("elm.violation_s + 1 == none.violation_s", values));
  EXPECT_TRUE(holds("elm.violation_s <= 1", values));
  EXPECT_FALSE(holds("elm.violation_s <= 9.99e-1", values));
  EXPECT_TRUE(holds("-1 * elm.violation_s < -0.5", values));
  EXPECT_TRUE(holds("  elm.violation_s<=none.violation_s  ", values));
}

TEST(Claims, NamesMayLookLikeNumbers) {
  EXPECT_EQ(claim_of("2fast.lap0_s < n-20.lap0_s").left.stack, "2fast");
  EXPECT_EQ(claim_of("2 * 2fast.lap0_s < n-20.lap0_s").left.factor, 2.0);
  EXPECT_EQ(claim_of("n-20.lap0_s < infinite.lap0_s").right.stack, "infinite");
}

TEST(Claims, NamesMayHaveDots) {
  EXPECT_EQ(claim_of("w0.3.violation_s <= elm.violation_s").left.stack, "w0.3");
  const Claim claim = claim_of("elm.violation_s-0.5 <= 1.5*v1.a.violation_s-1");
  EXPECT_EQ(claim.left.stack, "elm");
  EXPECT_EQ(claim.left.offset, -0.5);
  EXPECT_EQ(claim.right.stack, "v1.a");
  EXPECT_EQ(claim.right.column, "violation_s");
  EXPECT_EQ(claim.right.offset, -1.0);
  EXPECT_THAT(why("w0.3 <= 1"), HasSubstr("expected stack.column"));
}

TEST(Claims, RowsAndColumnsMustExist) {
  EXPECT_THAT(why("elmo.violation_s <= 1"), StartsWith("no stack \"elmo\"; did you mean \"elm\"?"));
  EXPECT_THAT(why("elm.violation <= 1"), StartsWith("no column \"violation\"; did you mean \"violation_s\"?"));
  EXPECT_THAT(why("elm.lap12 <= 1"), StartsWith("no column \"lap12\"; did you mean \"lap12_s\"?"));
  EXPECT_THAT(why("elm.mean_deviation <= 1"),
              StartsWith("no column \"mean_deviation\"; did you mean \"mean_deviation_m\""));
  EXPECT_THAT(why("elm.lap3_s < 8"), "nothing");
  EXPECT_THAT(why("elm.lap12_mean_factor < 8"), "nothing");
  EXPECT_THAT(why("elm.pace_ratio3 < 8"), "nothing");
  EXPECT_THAT(why("elm.lap_s < 8"), HasSubstr("no column \"lap_s\""));
  EXPECT_THAT(why("elm.status <= 1"), HasSubstr("no column \"status\""));
}

TEST(Claims, WhatIsNoClaimIsRefused) {
  EXPECT_THAT(why("elm.violation_s none.violation_s"),
              StartsWith("a claim compares with <, <=, >, >= or ==; found \"elm.violation_s none.violation_s\""));
  EXPECT_THAT(why("elm <= none.violation_s"), HasSubstr("expected stack.column, found \"elm \""));
  EXPECT_THAT(why("<= none.violation_s"), StartsWith("a value is missing before \"<=\""));
  EXPECT_THAT(why("elm.violation_s < "), StartsWith("a value is missing after \"<\""));
  EXPECT_THAT(why("elm.violation_s <= 1.05 none.violation_s "),
              StartsWith("a factor stands before \"*\": write 1.05 * none.violation_s"));
  EXPECT_THAT(why("elm.violation_s <= none.violation_s * 1.02"),
              StartsWith("a factor stands before \"*\": write 1.02 * none.violation_s"));
  EXPECT_THAT(why("elm.violation_s <= 2 * none.violation_s * 3"),
              StartsWith("cannot read \"* 3\"; a side of a claim is [number *] stack.column [+|- number]"));
  EXPECT_THAT(why("elm.violation_s <= none.violation_s / 2"), HasSubstr("cannot read \"/ 2\"; a side of a claim is"));
  EXPECT_THAT(why("elm.violation_s =< 1"), StartsWith("\"=<\" is written \"<=\""));
  EXPECT_THAT(why("elm.violation_s => 1"), StartsWith("\"=>\" is written \">=\""));
  EXPECT_THAT(why("elm.violation_s \u2264 1"), HasSubstr("is written \"<=\""));
  EXPECT_THAT(why("elm.violation_s = 1"), HasSubstr("; \"=\" is written \"==\""));
  EXPECT_THAT(why("elm.violation_s + x <= 1"), HasSubstr("expected a number in"));
  EXPECT_THAT(why("elm.violation_s < none.violation_s < gp.violation_s"), HasSubstr("cannot read"));
  EXPECT_THAT(why("elm.violation_s <= inf"), HasSubstr("expected stack.column"));
  EXPECT_THAT(why(""), HasSubstr("a claim compares with"));
  Errors errors;
  EXPECT_FALSE(read_claim(Node(3.0), stacks, errors).has_value());
  EXPECT_THAT(errors.sorted().at(0).text(),
              HasSubstr("expected a claim such as \"a.violation_s <= b.violation_s\", found 3"));
}

TEST(Claims, TimesAreKnown) {
  EXPECT_TRUE(claim_of("elm.solve_ms_median < gp.solve_ms_median").about_time());
  EXPECT_TRUE(claim_of("elm.lap0_s < 3 * gp.update_ms_median").about_time());
  EXPECT_TRUE(claim_of("elm.cpu_s < 10").about_time());
  EXPECT_FALSE(claim_of("elm.simulated_s < 10").about_time());
}

TEST(Claims, HoldForTheMedianAndForEnoughRuns) {
  Values values;
  values.runs = {{"elm.violation_s", {0, 0, 0, 0, 9}}, {"none.violation_s", {1, 1, 1, 1, 1}}};
  values.medians = {{"elm.violation_s", 0}, {"none.violation_s", 1}};
  const Claim claim = claim_of("elm.violation_s <= none.violation_s");
  const ClaimResult four = judge(claim, 5, 0.8, values);
  EXPECT_TRUE(four.holds.value());
  EXPECT_EQ(four.runs_held, 4);
  EXPECT_EQ(four.runs, 5);
  EXPECT_EQ(four.left, 0);
  EXPECT_EQ(four.right, 1);
  const ClaimResult refuted = judge(claim, 5, 0.81, values);
  EXPECT_FALSE(refuted.holds.value());
  EXPECT_TRUE(refuted.medians_hold);
  EXPECT_EQ(refuted.share, 0.81);
  values.medians["elm.violation_s"] = 2;
  EXPECT_FALSE(judge(claim, 5, 0.8, values).holds.value());
  EXPECT_FALSE(judge(claim, 5, 0.8, values).medians_hold);
  EXPECT_EQ(judge(claim, 5, 0.8, values).text, "elm.violation_s <= none.violation_s");
}

/// No run alone has five finished runs.
TEST(Claims, SumsAndLargestValuesAreNotAskedOfSingleRuns) {
  Values values;
  values.runs = {{"elm.finished", {1, 1, 1, 1, 1}}, {"elm.violation_s", {0, 1, 2, 3, 4}}};
  values.medians = {{"elm.finished", 5}, {"elm.runs", 5}, {"elm.violation_s_max", 4}, {"elm.violation_s", 2}};
  for (const char* text : {"elm.finished == 5", "elm.finished == elm.runs", "5 <= elm.finished",
                           "elm.violation_s_max >= 4", "elm.violation_s_max == 2 * elm.violation_s"}) {
    const ClaimResult result = judge(claim_of(text), 5, 0.8, values);
    EXPECT_TRUE(result.holds.value()) << text;
    EXPECT_EQ(result.runs, 0) << text;
  }
  EXPECT_FALSE(judge(claim_of("elm.finished >= 6"), 5, 0.8, values).holds.value());
  EXPECT_TRUE(claim_of("elm.violation_s <= 2").about_single_runs());
}

TEST(Claims, OtherTablesHaveOtherColumns) {
  const std::vector<std::string> names = {"drag"}, columns = {"named", "closure"};
  Errors errors;
  EXPECT_TRUE(read_claim(Node("drag.closure >= 0.95"), names, errors, columns));
  EXPECT_TRUE(errors.empty());
  (void)read_claim(Node("drag.closur >= 0.95"), names, errors, columns);
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_THAT(errors.sorted().front().text(), testing::HasSubstr("did you mean \"closure\"?"));
}

TEST(Claims, WhatWasNotMeasuredMakesNoClaimTrue) {
  Values values = constant(0, 1);
  EXPECT_FALSE(holds("elm.lap0_s <= none.violation_s", values));
  EXPECT_FALSE(holds("elm.violation_s <= gp.violation_s", values));
  EXPECT_FALSE(holds("elm.lap0_s >= gp.lap0_s", values));
  values.runs["elm.violation_s"] = {};  // a run is missing: the share is not reached
  EXPECT_FALSE(holds("elm.violation_s <= none.violation_s", values));
}

}  // namespace test_claims
}  // namespace gripline
