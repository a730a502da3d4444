#include "diagnose/result/diagnosis_files.hpp"

#include <gtest/gtest.h>

namespace gripline::diagnose {
namespace test_diagnose_diagnosis_files {

/// A reader of numbers alone must see that one is no estimate.
TEST(DiagnoseDiagnosisFiles, AParameterAtAnEndOfItsRangeSaysWhich) {
  Diagnosis d;
  NamedEffect& offset = d.named.emplace_back();
  offset.effect = "yawrate_bias";
  offset.params = {{"b", "rad/s", -0.1, -0.11, -0.09, "low"}};
  NamedEffect& lag = d.named.emplace_back();
  lag.effect = "steer_lag";
  lag.params = {{"tau", "s", 0.04, 0.038, 0.042}};
  const Node::Array named = diagnosis_json(d).find("named")->array();
  ASSERT_EQ(named.size(), 2u);
  ASSERT_NE(named[0].find("at_end"), nullptr);
  EXPECT_EQ(named[0].find("at_end")->find("b")->text(), "low");
  EXPECT_EQ(named[0].find("params")->find("b")->number(), -0.1);
  EXPECT_EQ(named[1].find("at_end"), nullptr);
}

/// Evidence and a decrease of errors are not one number: each has its key, and only one is there.
TEST(DiagnoseDiagnosisFiles, EvidenceAndADecreaseOfErrorsHaveKeysOfTheirOwn) {
  Diagnosis d;
  d.ranking = {{.effect = "steer_lag", .gain = 812.4}, {.effect = "aero_drag", .less_error = 0.25}};
  const Node::Array ranking = diagnosis_json(d).find("ranking")->array();
  ASSERT_EQ(ranking.size(), 2u);
  EXPECT_EQ(ranking[0].find("gain")->number(), 812.4);
  EXPECT_EQ(ranking[0].find("less_error"), nullptr);
  EXPECT_EQ(ranking[1].find("less_error")->number(), 0.25);
  EXPECT_EQ(ranking[1].find("gain"), nullptr);
}

}  // namespace test_diagnose_diagnosis_files
}  // namespace gripline::diagnose
