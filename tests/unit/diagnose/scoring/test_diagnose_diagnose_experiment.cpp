#include "diagnose/scoring/diagnose_experiment.hpp"

#include <gtest/gtest.h>

#include "support/comma_locale.hpp"

namespace gripline::diagnose {
namespace {

using DiagnoseExperimentTable = testing_support::InCommaLocale;

TEST_F(DiagnoseExperimentTable, HasPointsAndOneCellForEveryName) {
  DiagnoseOutcome outcome;
  outcome.cases.push_back({"drag, wet", "", Verdict::named, {{"named", 1.0}, {"confidence", 0.9876543}, {"to", 12.5}}});
  EXPECT_EQ(
      outcome_csv(outcome),
      "case,verdict,named,nothing_missing,indistinguishable,unknown,right,confidence,before,after,closure,from,to,"
      "round_trip\n\"drag, wet\",named,1,,,,,0.987654,,,,,12.5,\n");
}

}  // namespace
}  // namespace gripline::diagnose
