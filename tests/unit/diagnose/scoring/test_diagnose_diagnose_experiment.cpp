#include "diagnose/scoring/diagnose_experiment.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/comma_locale.hpp"
#include "support/host_support.hpp"

namespace gripline::diagnose {
namespace test_diagnose_diagnose_experiment {

double right(const std::vector<Names>& missing, bool hidden, const Diagnosis& d) {
  for (const auto& [name, value] : outcome_of("one", answer_of(missing, hidden), d).values)
    if (name == "right") return value;
  return -1.0;
}

/// Cases of experiments are judged as blind ones are: a verdict that names nothing is not always the right one, and a
/// channel that is not late is a false name.
TEST(DiagnoseExperiment, JudgesByTheRulesOfScores) {
  Diagnosis d;
  d.verdict = Verdict::unknown;
  EXPECT_EQ(right({}, false, d), 0.0) << "nothing is missing";
  EXPECT_EQ(right({}, true, d), 1.0);
  d.verdict = Verdict::named;
  d.delays.emplace_back().effect = "yaw_rate_delay";
  EXPECT_EQ(right({}, false, d), 0.0);
  d.named.emplace_back().effect = "aero_drag";
  EXPECT_EQ(right({{"aero_drag"}}, true, d), 0.0) << "no channel is late";
  d.delays.clear();
  EXPECT_EQ(right({{"aero_drag"}}, true, d), 1.0);
  EXPECT_EQ(right({{"wind"}, {"aero_drag"}}, true, d), 1.0);
  d.verdict = Verdict::unknown;
  EXPECT_EQ(right({{"aero_drag"}}, true, d), 0.0);
}

TEST(DiagnoseExperiment, AFilterOfTheDriversStateRefusesLateSensors) {
  const Node tree = testing_support::json(R"({"kind": "diagnose", "nominal": "diagnose_rc43.json",
    "driver": {"model": {"plugin": "ekinematic"}, "planner": {"plugin": "fixed_speed"},
               "controller": {"plugin": "pure_pursuit"}, "state_filter": {"sigma": {}}},
    "cases": {"plain": {}, "late": {"hidden": {"sensors": {"delay": {"vy": "40 ms"}}}}}})");
  EXPECT_THAT(testing_support::refusal([&] { check_diagnose_experiment(tree, testing_support::plugins()); }),
              testing::AllOf(testing::HasSubstr("/driver/state_filter: the filter takes readings for those of now"),
                             testing::HasSubstr("have a delay (vy)"), testing::EndsWith("[case late]")));
}

using DiagnoseExperimentTable = testing_support::InCommaLocale;

TEST_F(DiagnoseExperimentTable, HasPointsAndOneCellForEveryName) {
  DiagnoseOutcome outcome;
  outcome.cases.push_back({"drag, wet", "", Verdict::named, {{"named", 1.0}, {"confidence", 0.9876543}, {"to", 12.5}}});
  EXPECT_EQ(
      outcome_csv(outcome),
      "case,verdict,named,nothing_missing,indistinguishable,unknown,right,confidence,before,after,closure,from,to,"
      "round_trip\n\"drag, wet\",named,1,,,,,0.987654,,,,,12.5,\n");
}

}  // namespace test_diagnose_diagnose_experiment
}  // namespace gripline::diagnose
